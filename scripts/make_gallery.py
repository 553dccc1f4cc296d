"""Draw every figure of the project into a folder and write the page that shows them, with captions and commands."""

import argparse
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Entry:
    """One figure: the file in the folder, the commands that make it (the last one writes it), title and caption."""

    file: str
    commands: tuple[str, ...]
    title: str
    caption: str


ENTRIES = (
    Entry(
        "steady.png",
        ("python scripts/plot_steady_map.py -o {folder}/steady.png",),
        "All steady motions of a rolling disk",
        "Every steady motion of the uniform disk (R = 0.5 m) is a point of the plane of tilt and precession rate "
        "(left) or of tilt and roll rate (middle). Each cell was kicked and integrated: purple, the frequency of "
        "nutation; orange and hatched, unstable, the rate at which the kick grows. Points: the boundary that RK4 "
        "finds, bisected to 1e-9; black: k = 0 of linear theory, whose ends at zero tilt are the lines of "
        "spinning and rolling; dashed: where the criterion (ten times the kick) puts it. In the plane of the roll"
        " rate a motion has two precession rates; the slower one is drawn, and with the faster one every motion "
        "is stable. Right: measured rates against the root of |k|. The rise to the left is rounding near k = 0, "
        "that to the right the size of the kick. 66 of 81840 cells, near-flat and hardly precessing, stay unresolved.",
    ),
    Entry(
        "convergence.png",
        ("python scripts/plot_convergence.py -o {folder}/convergence.png",),
        "The critical rates, by integration alone",
        "Left: critical rates of rolling and spinning for seven mass distributions, extrapolated from "
        "integrations to no kick and to the strictest criterion; lines: theory. Middle: how the uniform disk gets"
        " there, from below when the criterion is an angle of departure, from above when it is an amplification. "
        "Right: what is left of the difference. No analytic value enters the measurement.",
    ),
    Entry(
        "alphas.png",
        ("python scripts/plot_alphas.py -o {folder}/alphas.png",),
        "From a point mass at the centre to the hoop",
        "The boundary of stable circling for five mass distributions, out of one atlas of three axes: unstable "
        "inside. A hoop is stable at lower rates than a disk, but it can be unstable up to a larger tilt.",
    ),
    Entry(
        "regimes.png",
        ("python scripts/plot_regimes.py -o {folder}/regimes.png",),
        "One well or two, one side of upright or both",
        "Tilts and rates from which a disk that only rolls (left) or only spins (right) has a potential of one well "
        "or of two, and whether it crosses upright, by the exact reduction. A disk released at rest (top) never does; "
        "a pushed one (bottom) passes the saddle left of the dashed separatrix, or swings to the other side of the "
        "only well. Black: the curve of folds from theory alone, the steady motions with k = 0 carried to the tilt "
        "at which they only roll, or only spin. It starts at the critical rates.",
    ),
    Entry(
        "bifurcation.png",
        ("python scripts/plot_bifurcation.py -o {folder}/bifurcation.png",),
        "Steady motions that share the two constants of a motion",
        "Left: the plane of the two constants of Chaplygin's integrals. Hatched: two wells found by the exact "
        "reduction, so three steady motions; the fold line around it is the image of k = 0, its cusps are "
        "critical rolling and critical spinning. Middle: energies along the three dotted sections, less that of "
        "the upright disk; stable and unstable motions meet at the folds. Right: a nutation period turns the path"
        " of the contact point about a fixed centre, so that the drift stays in a ring, unless the heading comes "
        "back to itself. Form of the diagrams: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201.",
    ),
    Entry(
        "boundaries.png",
        (
            "python scripts/compute_atlases.py -o {folder}/atlases",
            "python scripts/plot_boundaries.py {folder}/atlases/rolling.nc {folder}/atlases/spinning.nc "
            "{folder}/atlases/circling.nc -o {folder}/boundaries.png",
        ),
        "Rolling, spinning and circling",
        "The three presets: peak tilt, the boundary that RK4 finds, the line of theory, and the boundary that the"
        " criterion predicts for the perturbation. Below, the boundary over the line.",
    ),
)


def page(entries: tuple[Entry, ...] = ENTRIES) -> str:
    """Return the page as Markdown."""
    parts = [
        "# Gallery\n\nEvery figure of the project, with the command that makes it. `scripts/gallery` makes them all.\n"
    ]
    for each in entries:
        commands = "\n".join(command.format(folder="docs") for command in each.commands)
        parts.append(
            f"## {each.title}\n\n![{each.title}]({each.file})\n\n{each.caption}\n\n```bash\n{commands}\n```\n"
        )
    return "\n".join(parts)


def main() -> None:
    """Run the commands, one after the other, and write gallery.md beside the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", "-o", type=Path, default=CHECKOUT / "docs", help="folder (default: docs)")
    parser.add_argument("--only", nargs="*", metavar="FILE", help="these figures, and the page")
    request = parser.parse_args()
    folder = request.output.resolve()
    for each in ENTRIES:
        if request.only is not None and each.file not in request.only:
            continue
        for command in each.commands:
            words = shlex.split(command.format(folder=shlex.quote(str(folder))))
            print(shlex.join(words), file=sys.stderr)
            done = subprocess.run([sys.executable, *words[1:]], cwd=CHECKOUT, check=False)
            if done.returncode:
                sys.exit(f"{command}: exit status {done.returncode}")
    (folder / "gallery.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
