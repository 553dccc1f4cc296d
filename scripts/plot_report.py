"""Draw the six figures of the report from which this project started, with linear theory, into one folder."""

import argparse
from pathlib import Path
from typing import Any

from figure_cli import run_script
from matplotlib.font_manager import FontProperties

import sweep
from sweep.figures import plots
from sweep.figures.disk import motion_plots
from sweep.figures.panels_in_time import thin_panels
from sweep.figures.sheet import sheet
from sweep.files.paths import check_format

#: The report's runs: uniform disk, R = 0.5 m, m = 1 kg, g = 9.81 m/s2 (the defaults).
RUNS: dict[str, dict[str, Any]] = {
    "rolling 3": {"tilt_rate": 0.01, "roll_rate": 3.0, "title": "Rolling at 3 rad/s: stable"},
    "rolling 2": {"tilt_rate": 0.01, "roll_rate": 2.0, "title": "Rolling at 2 rad/s: unstable"},
    "spinning 4.5": {"tilt_rate": 0.1, "precession_rate": 4.5, "title": "Spinning at 4.5 rad/s: stable"},
    "spinning 3.5": {"tilt_rate": 0.1, "precession_rate": 3.5, "title": "Spinning at 3.5 rad/s: unstable"},
    "circling": {
        "tilt": "10deg",
        "precession_rate": 0.5,
        "roll_rate": "steady",
        "duration": "13s",
        "title": "Circling at 10 deg",
    },
}

_ROLLING, _SPINNING = ("rolling 3", "rolling 2"), ("spinning 4.5", "spinning 3.5")

#: File -> the drawing function and its runs.
FIGURES = {
    "momentum": (motion_plots.draw_momentum, (*_ROLLING, "spinning 3.5")),
    "rolling-path": (motion_plots.draw_path, _ROLLING),
    "rolling-tilt": (motion_plots.draw_tilt, _ROLLING),
    "spinning-path": (motion_plots.draw_path, _SPINNING),
    "spinning-tilt": (motion_plots.draw_tilt, _SPINNING),
    "circling-path": (motion_plots.draw_path, ("circling",)),
}


def side_by_side(motions: Any, draw: Any) -> Any:
    """Return a figure of motions, one panel each with its title."""
    with sheet(3.5 * len(motions), 3.0) as drawn:
        panels = list(drawn.subplots(1, len(motions), squeeze=False).flat)
        for axes, motion in zip(panels, motions, strict=True):
            draw(axes, motion)
            axes.get_legend().set_title(motion.attrs["title"], FontProperties(size=8.5, weight="bold"))
        thin_panels(panels)
    return drawn


def main() -> None:
    """Write the figures into the output folder, which is created if necessary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--output", "-o", type=Path, default=Path("report"), help="folder (default: %(default)s)"
    )
    parser.add_argument("--format", default="png", help="png, pdf or svg (default: %(default)s)")
    request = parser.parse_args()
    files = {name: request.output / f"{name}.{request.format}" for name in FIGURES}
    for path in files.values():
        check_format(path)
    request.output.mkdir(parents=True, exist_ok=True)
    motions = {name: sweep.simulate(**words) for name, words in RUNS.items()}
    for name, (draw, runs) in FIGURES.items():
        plots.save(side_by_side([motions[run] for run in runs], draw), files[name])
        print(files[name])


if __name__ == "__main__":
    run_script(main)
