"""Draw the regimes of rolling and spinning disks, released at rest and pushed, in a wider plane than the presets'."""

from pathlib import Path

from figure_cli import figure_parser, run_script

import sweep
from sweep.figures import plots
from sweep.figures.disk import regimes
from sweep.files.paths import check_format

#: Preset -> its rate and the values of that rate [rad/s]: up to 1.6 times the critical one.
_PLANES = {
    "rolling": ("roll_rate", "0:4.1:300", "Rolling"),
    "spinning": ("precession_rate", "0:6.3:300", "Spinning"),
}
_TILTS = "0.1deg:45deg:300"
_PUSHES = {"released at rest": "0", "pushed at 1.5 rad/s": "1.5rad/s"}


def save_regimes(path: Path) -> None:
    """Compute four atlases with the exact method and draw their regimes."""
    datasets = []
    for push, rate_of_tilt in _PUSHES.items():
        for preset, (rate, values, name) in _PLANES.items():
            spec = sweep.SweepSpec.preset(preset).replace(
                **{rate: values}, tilt=_TILTS, tilt_rate=rate_of_tilt, method="exact", title=f"{name}, {push}"
            )
            datasets.append(sweep.run(spec))
    plots.save(regimes.figure(datasets), path)


def main() -> None:
    """Write the figure."""
    path = figure_parser(__doc__, "regimes.png").parse_args().output
    check_format(path)
    save_regimes(path)


if __name__ == "__main__":
    run_script(main)
