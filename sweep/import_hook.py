"""A hook that runs a function once a module has been imported, without importing it."""

import importlib.util
import sys
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any


def when_imported(name: str, action: Callable[[], object]) -> None:
    """Call `action` once, as soon as the module `name` has been imported; now if it already is.

    Users may import this package and xarray in either order, and expect the accessor in both cases. But the command
    line must answer --help without loading xarray, which takes half a second.
    """
    if name in sys.modules:
        action()
    # a reload of the caller asks again
    elif not any(isinstance(each, _Finder) and each.name == name for each in sys.meta_path):
        sys.meta_path.insert(0, _Finder(name, action))


class _Finder:
    """A finder that delegates one module to the other finders and calls the action after the module has run.

    It does not derive from `importlib.abc.MetaPathFinder`, which adds nothing needed and takes 6 ms to import.
    """

    def __init__(self, name: str, action: Callable[[], object]) -> None:
        self.name = name
        self.action = action
        self.asking = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec from the other finders for this one module, otherwise None."""
        if fullname != self.name or self.asking:
            return None
        self.asking = True
        try:
            spec = importlib.util.find_spec(fullname)
        finally:
            self.asking = False
        if spec is None or spec.loader is None:
            return spec
        # The loader is patched only until it executes the module. If a caller needs the spec only to see whether the
        # module is installed, it never executes the module, and nothing happens.
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
