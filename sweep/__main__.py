"""``python -m sweep`` is ``eulerdisk``."""

from sweep.cli import main

main()
