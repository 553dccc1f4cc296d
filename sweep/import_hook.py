"""Run a function as soon as a module has been imported, without importing it."""

import importlib.util
import sys
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any


def when_imported(name: str, action: Callable[[], object]) -> None:
    """Call `action` once, after the module `name` has been imported: now, if it is already.

    A user may import this package and xarray in either order, and expects the accessor in both cases. But the command
    line must answer --help without xarray, which takes half a second to load.
    """
    if name in sys.modules:
        action()
    # a module that is imported again asks again
    elif not any(isinstance(each, _Finder) and each.name == name for each in sys.meta_path):
        sys.meta_path.insert(0, _Finder(name, action))


class _Finder:
    """A finder that lets the others find one module, and calls the action at the end of its execution.

    Not derived from `importlib.abc.MetaPathFinder`, which adds nothing that is used, and takes 6 ms to import.
    """

    def __init__(self, name: str, action: Callable[[], object]) -> None:
        self.name = name
        self.action = action
        self.asking = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return what the other finders find; None for all other modules."""
        if fullname != self.name or self.asking:
            return None
        self.asking = True
        try:
            spec = importlib.util.find_spec(fullname)
        finally:
            self.asking = False
        if spec is None or spec.loader is None:
            return spec
        # The loader object is changed only until it executes the module. A caller that asks for the spec only to know
        # whether the module is installed never executes it, and nothing happens.
        loader: Any = spec.loader
        execute = loader.exec_module

        def exec_module(module: ModuleType) -> None:
            del loader.exec_module
            execute(module)
            if self in sys.meta_path:
                sys.meta_path.remove(self)
                self.action()

        loader.exec_module = exec_module
        return spec
