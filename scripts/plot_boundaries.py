"""Draw atlases side by side: stability map, measured boundary, analytic line and predicted boundary."""

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

import sweep
from sweep.figures import plots
from sweep.files.filenames import check_format


def main() -> None:
    """Draw the atlases named on the command line into one figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("atlases", nargs="+", type=Path, metavar="ATLAS.nc", help="one panel each")
    parser.add_argument(
        "--output",
        "-o",
        type=Path,
        default=Path("boundaries.png"),
        help="png, pdf or svg (default: %(default)s)",
    )
    request = parser.parse_args()
    check_format(request.output)
    with ExitStack() as opened:
        datasets = [opened.enter_context(sweep.open_atlas(path)) for path in request.atlases]
        plots.save(plots.figure(datasets), request.output)


if __name__ == "__main__":
    try:
        main()
    except sweep.RequestError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
