"""``python -m sweep`` runs the command ``eulerdisk``."""

from sweep.cli import main

main()
