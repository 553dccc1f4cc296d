"""Compile one entry point and keep it on disk: ``python -m sweep.model.compile_entry MODULE FUNCTION``."""

import sys

from sweep.model.kernel import Kernel

if __name__ == "__main__":
    _, module, function = sys.argv
    Kernel(module, function).keep()
