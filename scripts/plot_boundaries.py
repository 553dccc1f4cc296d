"""Draw atlases side by side: stability map, measured boundary, analytic line and predicted boundary."""

from contextlib import ExitStack
from pathlib import Path

from figure_cli import figure_parser, run_script

import sweep
from sweep.figures import plots
from sweep.files.paths import check_format


def main() -> None:
    """Draw the atlases named on the command line into one figure."""
    parser = figure_parser(__doc__, "boundaries.png")
    parser.add_argument("atlases", nargs="+", type=Path, metavar="ATLAS.nc", help="one panel each")
    request = parser.parse_args()
    check_format(request.output)
    with ExitStack() as opened:
        datasets = [opened.enter_context(sweep.open_atlas(path)) for path in request.atlases]
        plots.save(plots.figure(datasets), request.output)


if __name__ == "__main__":
    run_script(main)
