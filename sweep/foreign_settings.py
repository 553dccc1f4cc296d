"""Files with which other libraries are set up, and which lie in whatever folder a command is called in.

Numba takes its settings from ``.numba_config.yaml``, and compiled code of other bits may follow from them; matplotlib
takes its own from ``matplotlibrc``, and netCDF-C, for files on servers, from ``.ncrc`` and ``.dodsrc``. An atlas is a
function of its request and a figure one of its atlases, so none of them is read.
"""

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator
from functools import lru_cache
from importlib.machinery import ModuleSpec
from pathlib import Path

from sweep.import_hook import when_imported


def ignore_numba_file() -> None:
    """Make ``.numba_config.yaml`` without effect in this process; the variables NUMBA_* of the environment keep theirs.

    If Numba has been imported before, what it took from the file is taken back.
    """
    when_imported("numba.core.config", _forget_numba_file, _without_yaml)


def ignore_ncrc() -> None:
    """Let netCDF-C start without ``.ncrc`` and ``.dodsrc``, of which a pipe would hold it for ever.

    For the command line only, before netCDF is loaded: a user's program may read files on servers.
    """
    os.environ["NCRCENV_IGNORE"] = "1"


@lru_cache
def ignore_matplotlibrc() -> None:
    """Let matplotlib start with its own defaults in this process: no matplotlibrc, no $MPLBACKEND.

    For the command line only: in Python the settings of matplotlib are those of the user's program, and each figure of
    this package is drawn in its own style.
    """
    when_imported("matplotlib", lambda: None, _in_its_own_folder)


@contextlib.contextmanager
def _without_yaml(spec: ModuleSpec) -> Iterator[None]:
    # Numba reads the file while this module is executed, if it finds a reader for it; a damaged file would end it
    missing = object()
    before = sys.modules.get("yaml", missing)
    sys.modules["yaml"] = None  # type: ignore[assignment]  # to the import system: there is no such module
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        if before is missing:
            del sys.modules["yaml"]
        else:
            sys.modules["yaml"] = before  # type: ignore[assignment]


def _forget_numba_file() -> None:
    from numba.core import config

    # Numba looks for the file again before every compilation
    config._config_fname = ""
    if not config._env_reloader.old_environ.keys() <= os.environ.keys():
        # the number of threads cannot be changed once they run, and decides no bits
        with contextlib.suppress(RuntimeError):
            config.reload_config()


@contextlib.contextmanager
def _in_its_own_folder(spec: ModuleSpec) -> Iterator[None]:
    # matplotlib takes the first matplotlibrc that it finds, and looks in the current folder first: its own is here
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        with contextlib.ExitStack() as stack:
            with contextlib.suppress(OSError):
                here = os.getcwd()
                os.chdir(Path(str(spec.origin)).parent / "mpl-data")
                stack.callback(os.chdir, here)
            yield
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
