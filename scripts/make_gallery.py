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
    """Figures that belong together: files in the folder, the commands that make them, title and caption.

    The last command writes the files. `made_here` is false for what takes an extra and many minutes.
    """

    files: tuple[str, ...]
    commands: tuple[str, ...]
    title: str
    caption: str
    made_here: bool = True


ENTRIES = (
    Entry(
        ("steady.png",),
        ("python scripts/plot_steady_map.py -o {folder}/steady.png",),
        "All steady motions of a rolling disk",
        "Every steady motion of the uniform disk (R = 0.5 m) is a point of the plane of tilt and precession rate "
        "(left) or of tilt and roll rate (middle). Each cell was kicked and integrated: purple, the frequency of "
        "nutation; orange and hatched, unstable, the rate at which the kick grows. Points: the boundary that RK4 "
        "finds, bisected to 1e-9; black: k = 0 of linear theory, whose ends at zero tilt are the lines of "
        "spinning and rolling; dashed: where the criterion (ten times the kick) puts it. In the plane of the roll"
        " rate a motion has two precession rates; the slower one is drawn, and with the faster one every motion "
        "is stable. Right: measured rates against the root of |k|. The rise to the left is what a kick of "
        "finite size does near k = 0. No cell beyond the predicted offset is against the sign of k, and none is "
        "undecided.",
    ),
    Entry(
        ("convergence.png",),
        ("python scripts/plot_convergence.py -o {folder}/convergence.png",),
        "The critical rates, by integration alone",
        "Left: critical rates of rolling and spinning for seven mass distributions, extrapolated from "
        "integrations to no kick and to the strictest criterion; lines: theory. Middle: how the uniform disk gets"
        " there, from below when the criterion is an angle of departure, from above when it is an amplification. "
        "Right: what is left of the difference, at least 1e-13. No analytic value enters the measurement.",
    ),
    Entry(
        ("alphas.png",),
        ("python scripts/plot_alphas.py -o {folder}/alphas.png",),
        "From a point mass at the centre to the hoop",
        "The boundary of stable circling for five mass distributions, out of one atlas of three axes: unstable "
        "inside. A hoop is stable at lower rates than a disk, but it can be unstable up to a larger tilt.",
    ),
    Entry(
        ("regimes.png",),
        ("python scripts/plot_regimes.py -o {folder}/regimes.png",),
        "One well or two, one side of upright or both",
        "Tilts and rates from which a disk that only rolls (left) or only spins (right) has a potential of one well "
        "or of two, and whether it crosses upright, by the exact reduction. A disk released at rest (top) never does; "
        "a pushed one (bottom) passes the saddle left of the dashed separatrix, or swings to the other side of the "
        "only well. Black: the curve of folds from theory alone, the steady motions with k = 0 carried to the tilt "
        "at which they only roll, or only spin. It starts at the critical rates.",
    ),
    Entry(
        ("bifurcation.png",),
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
        ("boundaries.png",),
        (
            "python scripts/compute_atlases.py -o {folder}/atlases",
            "python scripts/plot_boundaries.py {folder}/atlases/rolling.nc {folder}/atlases/spinning.nc "
            "{folder}/atlases/circling.nc -o {folder}/boundaries.png",
        ),
        "Rolling, spinning and circling",
        "The three presets: peak tilt, the boundary that RK4 finds, the line of theory, and the boundary that the"
        " criterion predicts for the perturbation. Below, the boundary over the line.",
    ),
    Entry(
        ("random.png",),
        (
            "python -m sweep run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=2e4 seed=7 "
            "-o {folder}/random-rolling.nc --overwrite",
            "python -m sweep run circling precession_rate=uniform:0.05:5 tilt=uniform:1deg:25deg samples=2e4 seed=7 "
            "-o {folder}/random-circling.nc --overwrite",
            "python -m sweep plot {folder}/random-rolling.nc {folder}/random-circling.nc -o {folder}/random.png",
        ),
        "Random starts of rolling and circling",
        "A point for each of 20,000 random starts, by its verdict, with the lines of theory; the share of the "
        "unstable ones with its 95 % interval stands below. See [starts from anywhere](starts.md).",
    ),
    Entry(
        ("maps.png", "family.png"),
        (
            "python -m sweep run rolling alpha=0.1,0.25,0.5,0.75,1 tilt=0.1deg:4deg:160 roll_rate=2:4:200 "
            "-o {folder}/alphas.nc --overwrite",
            "python -m sweep plot {folder}/alphas.nc --family --rate scaled -o {folder}/family.png",
            "python -m sweep plot {folder}/alphas.nc --contours 2deg,20deg -o {folder}/maps.png",
        ),
        "An atlas of three axes",
        "Rolling for five mass distributions: a map for each with lines of equal peak tilt, and all boundaries in one "
        "panel, rates in units of sqrt(g/R). [More of what figures can show](figures.md).",
    ),
    Entry(
        ("motion.png",),
        (
            "python -m sweep simulate tilt_rate=0.01 roll_rate=2 'title=Rolling at 2 rad/s: unstable' "
            "-o {folder}/motion.nc --plot {folder}/motion.png --overwrite",
        ),
        "One motion",
        "Unstable rolling for ten seconds: the disk in perspective at moments of its way, and below the tilt and the "
        "path with linear theory, which holds while the tilt is small, and what the contact has to bear.",
    ),
    Entry(
        ("fall.gif",),
        (
            "python -m sweep simulate radius=12mm tilt=1deg duration=0.188s 'title=A coin falls' -o {folder}/motion.nc "
            "--animate {folder}/fall.gif --size 480x360 --speed 0.05 --overwrite",
        ),
        "A film of one motion",
        "A coin is let go at a tilt of 1 degree and falls in a fifth of a second; the film shows it twenty times "
        "slower. Near flat, rolling would need more friction than there is: from there on the film is shaded, and it "
        "ends where only a plane that pulls would keep the coin from lifting off. How to film: [films](films.md).",
    ),
    Entry(
        ("ring.gif",),
        (
            "python -m sweep simulate body=torus tube=0.2 tilt=20deg roll_rate=3 duration=5.2s 'title=A ring rolls' "
            "-o {folder}/motion.nc --animate {folder}/ring.gif --size 340x240 --fps 15 --overwrite",
        ),
        "A film of another body",
        "A ring leans, rolls and nutates; its sides have two colours, and one meridian is painted. The film plays in "
        "real time. See [other bodies](bodies.md).",
    ),
    Entry(
        ("stopping.png",),
        (
            "python -m sweep simulate toy tilt=80deg \"title=Euler's disk stops\" -o {folder}/motion.nc "
            "--plot {folder}/stopping.png --overwrite",
        ),
        "How Euler's disk stops",
        "The toy from an inclination of 10 degrees, with dry contour friction and Bildsten's drag of air. Its wobble "
        "goes round ever faster while the disk itself hardly turns. The ledger says where the energy went: most to the "
        "contact, and more and more to the air. Below, inclination and precession rate against the time that is left, "
        "with the slopes that each law alone would give them: 2/3 and -1/3, 4/9 and -2/9.",
    ),
    Entry(
        ("stop.gif",),
        (
            "python -m sweep simulate radius=11.625mm tilt=50deg precession_rate=wobble roll_rate=wobble "
            "contour_friction=0.5mm 'title=A coin wobbles until it is flat' -o {folder}/motion.nc "
            "--animate {folder}/stop.gif --size 400x280 --fps 20 --overwrite",
        ),
        "A film of a motion that stops",
        "A coin with a worn edge wobbles about its centre, which stays over its place, and lies flat after a quarter "
        "of a second: sixteen times slower than it is.",
    ),
    Entry(
        ("losses.png",),
        (
            "python -m sweep run toy contour_friction=0.3um:30um:60:log tilt=50deg:89deg:60 precession_rate=wobble "
            "rolling_friction=15um \"title=Which loss stops Euler's disk\" -o {folder}/losses.nc --overwrite",
            "python -m sweep plot {folder}/losses.nc --losses -o {folder}/losses.png",
        ),
        "Which loss stops Euler's disk?",
        "Wobbles of the toy from many tilts, with rolling friction of 15 micrometres, Bildsten's drag of air, and "
        "more and more contour friction to the right. The hue is the law that took most of the energy, its strength "
        "the time aloft. Rolling friction decides far from flat, air near it, and contour friction where its arm is "
        "more than a few micrometres. What is measured: [why does it stop?](losses.md)",
    ),
    *(
        Entry(
            (f"{name}.png",),
            (
                f"python -m sweep run {name} {words} -o {{folder}}/{name}.nc --overwrite",
                f"python -m sweep plot {{folder}}/{name}.nc {drawn}-o {{folder}}/{name}.png",
            ),
            title,
            f"{caption} [Five systems](examples.md).",
        )
        for name, words, drawn, title, caption in (
            (
                "kapitza", "angle=1deg:85deg:100 shake=80:200:200", "", "Kapitza's pendulum",
                "The upper position of a pendulum on a shaken pivot holds above the points; for small angles that "
                "is the line, sqrt(2 g l)/a.",
            ),
            (
                "driven_pendulum", "torque=0:2:200 drive=0.2:1.6:200", "", "A driven pendulum",
                "Torques that turn a pendulum over lie above the points, and all above Melnikov's line.",
            ),
            (
                "henon_heiles", "u=-1:1:400 v=-1:1:400", "--quantity ending ", "The gaps of Henon and Heiles",
                "Through which of three gaps a star leaves the middle, by its velocity; inside the circle of the "
                "critical energy none does, and at the border of the gaps some cells are too sensitive to say.",
            ),
            (
                "magnets", "x=-1.5:1.5:400 y=-1.5:1.5:400", "--quantity label ", "Three magnets",
                "Over which magnet a pendulum of iron stops that is let go at rest.",
            ),
            (
                "thomas", "x=-10:10:400 y=-10:10:400 b=0.1665", "--quantity label ", "Thomas' system",
                "On which side of the origin motions of Thomas' cyclically symmetric system are at 200.",
            ),
        )
    ),
    Entry(
        tuple(
            f"report/{name}.png"
            for name in (
                "rolling-tilt", "rolling-path", "spinning-tilt", "spinning-path", "circling-path", "momentum",
            )
        ),
        ("python scripts/plot_report.py -o {folder}/report",),
        "The six figures of the report",
        "Tilts and paths of rolling, spinning and circling, each with linear theory, and the vertical angular momentum "
        "about the contact point, which is not conserved, with the integral of its balance law. What the report says "
        "of them, and what holds: [report](checked.md#the-report-reproduced).",
    ),
    Entry(
        ("work-precision.png", "scaling.png"),
        ("python scripts/benchmark.py --figures {folder}",),
        "Beside other ways to compute it",
        "Time per cell against the error of the peak tilt, and against the number of cells. This one takes the extra "
        "`bench` and many minutes, so `scripts/gallery` leaves it out.",
        made_here=False,
    ),
)  # fmt: skip


def page(entries: tuple[Entry, ...] = ENTRIES) -> str:
    """Return the page as Markdown."""
    parts = [
        "# Gallery\n\nEvery figure of the project, with the command that makes it. "
        "`scripts/gallery` makes them all, except for those of the benchmark at the end.\n"
    ]
    for each in entries:
        commands = "\n".join(command.format(folder="docs") for command in each.commands)
        figures = "\n".join(f"![{_alternative(each, file)}]({file})" for file in each.files)
        parts.append(f"## {each.title}\n\n{figures}\n\n{each.caption}\n\n```bash\n{commands}\n```\n")
    return "\n".join(parts)


def _alternative(entry: Entry, file: str) -> str:
    return entry.title if len(entry.files) == 1 else f"{entry.title}: {Path(file).stem.replace('-', ' ')}"


def main() -> None:
    """Run the commands, one after the other, and write gallery.md beside the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", "-o", type=Path, default=CHECKOUT / "docs", help="folder (default: docs)")
    parser.add_argument("--only", nargs="*", metavar="FILE", help="these figures, and the page")
    request = parser.parse_args()
    folder = request.output.resolve()
    for each in ENTRIES:
        if not each.made_here or (request.only is not None and not set(each.files) & set(request.only)):
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
