"""The command line of scripts that draw: the option for the figure, and exit statuses."""

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


def run_script(main: Callable[[], None]) -> None:
    """Run the main function of a script; a refused request ends it with a message and the error's exit status."""
    try:
        main()
    except sweep.RequestError as error:
        print(error, file=sys.stderr)
        sys.exit(error.status)
