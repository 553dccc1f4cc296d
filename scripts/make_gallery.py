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

    The last command writes the files. `made_here` is false for what takes an extra and many minutes. An entry without
    a caption is not in the gallery: another page shows and describes its figures.
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
        "Every steady motion of the uniform disk (R = 0.5 m), kicked and integrated, over tilt and precession rate "
        "(left) or roll rate (middle, the slower of two precession rates; with the faster one all are stable). "
        "Purple: stable, frequency of nutation. Orange and hatched: unstable, rate of growth. Points: the boundary "
        "by RK4, bisected to 1e-9. Black: k = 0 of linear theory. Dashed: the prediction for the criterion, ten "
        "times the kick. Right: measured rates against the root of |k|; the rise to the left comes from the finite "
        "kick.",
    ),
    Entry(
        ("convergence.png",),
        ("python scripts/plot_convergence.py -o {folder}/convergence.png",),
        "The critical rates, by integration alone",
        "Left: critical rates of rolling and spinning for seven mass distributions, extrapolated to no kick and to "
        "the strictest criterion; lines: theory. Middle: the approach for the uniform disk, from below with a "
        "departure, from above with an amplification. Right: the remaining difference, at least 1e-13. No analytic "
        "value enters the measurement.",
    ),
    Entry(
        ("alphas.png",),
        ("python scripts/plot_alphas.py -o {folder}/alphas.png",),
        "From a point mass at the centre to the hoop",
        "The boundary of stable circling for five mass distributions, from one atlas of three axes: "
        "unstable inside. A hoop is stable at lower rates than a disk, but can be unstable up to a larger "
        "tilt.",
    ),
    Entry(
        ("regimes.png",),
        ("python scripts/plot_regimes.py -o {folder}/regimes.png",),
        "One well or two, one side of upright or both",
        "Whether the potential of a disk that only rolls (left) or only spins (right) has one well or two, and "
        "whether the disk crosses upright, by the exact reduction. A disk released at rest (top) never does. A "
        "pushed one (bottom) passes the saddle left of the dashed separatrix, or crosses in the only well. Black: "
        "the curve of folds from theory, which starts at the critical rates.",
    ),
    Entry(
        ("bifurcation.png",),
        ("python scripts/plot_bifurcation.py -o {folder}/bifurcation.png",),
        "Steady motions that share the two constants of a motion",
        "Left: the plane of the two constants of Chaplygin's integrals. Hatched: two wells, so three steady motions. "
        "The fold line is the image of k = 0; its cusps are critical rolling and critical spinning. Middle: energies "
        "along the three dotted sections, less that of the upright disk. Right: each nutation period turns the path "
        "of the contact point about a fixed centre, so the drift stays in a ring, unless the heading comes back to "
        "itself. Form of the diagrams: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201.",
    ),
    Entry(
        ("boundaries.png",),
        (
            "python scripts/compute_atlases.py -o {folder}/atlases",
            "python scripts/plot_boundaries.py {folder}/atlases/rolling.nc {folder}/atlases/spinning.nc "
            "{folder}/atlases/circling.nc -o {folder}/boundaries.png",
        ),
        "Rolling, spinning and circling",
        "The three presets: peak tilt, the measured boundary, the line of theory, and the prediction for the "
        "criterion and the perturbation. Below: the boundary over the line.",
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
        "20,000 random starts each, coloured by verdict, with the lines of theory and the share of unstable starts "
        "with its 95 % interval. See [starts](starts.md).",
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
        "Rolling for five mass distributions: a map for each with lines of equal peak tilt, and all boundaries in "
        "one panel. See [figures](figures.md).",
    ),
    Entry(
        ("motion.png",),
        (
            "python -m sweep simulate tilt_rate=0.01 roll_rate=2 'title=Rolling at 2 rad/s: unstable' "
            "-o {folder}/motion.nc --plot {folder}/motion.png --overwrite",
        ),
        "One motion",
        "Unstable rolling for ten seconds: the disk in perspective, tilt and path with linear theory, "
        "which holds while the tilt is small, and the forces at the contact.",
    ),
    Entry(
        ("fall.gif",),
        (
            "python -m sweep simulate radius=12mm tilt=1deg duration=0.188s 'title=A coin falls' -o {folder}/motion.nc "
            "--animate {folder}/fall.gif --size 480x360 --speed 0.05 --overwrite",
        ),
        "A film of one motion",
        "A coin is let go at a tilt of 1 degree and falls in a fifth of a second, here twenty times slower. The film "
        "is shaded where rolling would need more friction than there is, and ends where the coin would lift off. See "
        "[films](motions.md#films).",
    ),
    Entry(
        ("ring.gif",),
        (
            "python -m sweep simulate body=torus tube=0.2 tilt=20deg roll_rate=3 duration=5.2s 'title=A ring rolls' "
            "-o {folder}/motion.nc --animate {folder}/ring.gif --size 340x240 --fps 15 --overwrite",
        ),
        "A film of another body",
        "A ring leans, rolls and nutates, in real time; its sides have two colours, and one meridian is "
        "painted. See [other bodies](bodies.md).",
    ),
    Entry(
        ("stopping.png",),
        (
            "python -m sweep simulate toy tilt=80deg \"title=Euler's disk stops\" -o {folder}/motion.nc "
            "--plot {folder}/stopping.png --overwrite",
        ),
        "How Euler's disk stops",
        "The toy from an inclination of 10 degrees, with dry contour friction and Bildsten's drag of air: where the "
        "energy went, and inclination and precession rate against the remaining time, with the slope of each law: "
        "2/3 and -1/3, 4/9 and -2/9.",
    ),
    Entry(
        ("stop.gif",),
        (
            "python -m sweep simulate radius=11.625mm tilt=50deg precession_rate=wobble roll_rate=wobble "
            "contour_friction=0.5mm 'title=A coin wobbles until it is flat' -o {folder}/motion.nc "
            "--animate {folder}/stop.gif --size 400x280 --fps 20 --overwrite",
        ),
        "A film of a motion that stops",
        "A coin with a worn edge wobbles about its resting centre and lies flat after a quarter of a "
        "second; the film is sixteen times slower.",
    ),
    Entry(
        ("losses.png",),
        (
            "python -m sweep run toy contour_friction=0.3um:30um:60:log tilt=50deg:89deg:60 precession_rate=wobble "
            "rolling_friction=15um \"title=Which loss stops Euler's disk\" -o {folder}/losses.nc --overwrite",
            "python -m sweep plot {folder}/losses.nc --losses -o {folder}/losses.png",
        ),
        "Which loss stops Euler's disk?",
        "Wobbles of the toy, with rolling friction of 15 micrometres, Bildsten's drag of air, and more contour "
        "friction to the right. The hue is the law that took most of the energy, its strength the time aloft. See "
        "[why does it stop?](losses.md)",
    ),
    *(
        Entry(
            (f"{name}.png",),
            (
                f"python -m sweep run {name} {words} -o {{folder}}/{name}.nc --overwrite",
                f"python -m sweep plot {{folder}}/{name}.nc {drawn}-o {{folder}}/{name}.png",
            ),
            title,
            "",  # docs/examples.md
        )
        for name, words, drawn, title in (
            ("kapitza", "angle=1deg:85deg:100 shake=80:200:200", "", "Kapitza's pendulum"),
            ("driven_pendulum", "torque=0:2:200 drive=0.2:1.6:200", "", "A driven pendulum"),
            ("henon_heiles", "u=-1:1:400 v=-1:1:400", "--quantity ending ", "The gaps of Henon and Heiles"),
            ("magnets", "x=-1.5:1.5:400 y=-1.5:1.5:400", "--quantity label ", "Three magnets"),
            ("thomas", "x=-10:10:400 y=-10:10:400 b=0.1665", "--quantity label ", "Thomas' system"),
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
        "Tilts and paths of rolling, spinning and circling, each with linear theory, and the vertical angular "
        "momentum about the contact point with the integral of its balance law. "
        "See [the report](checked.md#the-report-reproduced).",
    ),
    Entry(
        ("work-precision.png", "scaling.png"),
        ("python scripts/benchmark.py --figures {folder}",),
        "Beside other ways to compute it",
        "Time per cell against the error of the peak tilt, and against the number of cells. This needs "
        "the extra `bench` and many minutes, so `scripts/gallery` skips it.",
        made_here=False,
    ),
)  # fmt: skip


def page(entries: tuple[Entry, ...] = ENTRIES) -> str:
    """Return the page as Markdown."""
    parts = [
        "# Gallery\n\nThe figures of the project, with the commands that make them; [five systems](examples.md) have "
        "their own page. `scripts/gallery` makes all figures, except those of the benchmark at the end.\n"
    ]
    for each in (entry for entry in entries if entry.caption):
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
