"""Compile entry points and keep them on disk: ``python -m sweep.model.compile_entry MODULE:FUNCTION...``."""

import sys

from sweep.model.kernel import Kernel

if __name__ == "__main__":
    for name in sys.argv[1:]:
        module, _, function = name.partition(":")
        Kernel(module, function).keep()
