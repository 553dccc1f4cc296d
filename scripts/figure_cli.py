"""What the scripts that draw have in common: the option for their figure, and how they refuse a request."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import sweep


def figure_parser(description: str | None, default: str) -> argparse.ArgumentParser:
    """Return a parser with the option --output for one figure."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(
        "--output", "-o", type=Path, default=Path(default), help="png, pdf or svg (default: %(default)s)"
    )
    return parser


def drive(main: Callable[[], None]) -> None:
    """Run a script: a request that cannot be met ends it with a message and the status of its kind."""
    try:
        main()
    except sweep.RequestError as error:
        print(error, file=sys.stderr)
        sys.exit(error.status)
