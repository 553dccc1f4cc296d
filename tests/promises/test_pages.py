"""The pages are true: their code blocks and the commands in their sentences are executed.

Each page has its own folder, in which its commands and Python run as printed, in order. A command in a
sentence is inline code that starts like one. Commands with an upper-case word or three dots are patterns; for
these the program must know the name and the options.
"""

import glob
import linecache
import os
import re
import shlex
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import lossy_runner
import pytest
from explorer_client import ask
from matplotlib import pyplot

from sweep.figures.disk.film_options import FilmOptions
from sweep.motion.origin import is_preset, request_of_preset
from sweep.motion.request import TrajectorySpec, split_motion_words
from sweep.request.spec import SweepSpec

pytestmark = [pytest.mark.slow_lane, pytest.mark.compiled]

CHECKOUT = Path(__file__).parents[2]
#: Pages with commands for readers; a changelog quotes old commands.
PAGES = {
    path.name: path for path in [*sorted((CHECKOUT / "docs").glob("*.md")), CHECKOUT / "CONTRIBUTING.md"]
}

#: Languages of blocks that other tests cover: the changes of extend.md, and the public names.
ELSEWHERE = {
    "extend.md": ({"bash", "diff", "python"}, "tests/promises/test_extend_page.py"),
    "api.md": ({"text"}, "tests/promises/test_public_names.py"),
}
#: Pages with commands that take minutes: blocks that contain this word. Their words are parsed and their
#: options checked.
READ_ONLY = {"gallery.md": "", "motions.md": "animate"}
#: Commands that are not run: they start servers, install other software, or change project files.
NOT_RUN = (
    "dask ",
    "run rolling -o atlas.nc --dask tcp",
    "run thomas device=cuda",
    "explore toy.nc",
    "pip ",
    "source ",
    "cp ",
    "pytest ",
    "python -m pytest ",
    "scripts/",
    "python scripts/",
)

#: Files that a page's commands read: name -> text, possibly a block of the page.
FILES = {
    "starts.md": {"pushes.csv": "csv"},
    "commands.md": {"pushed.toml": "toml"},
    "runs.md": {"sweeps/two.toml": "toml"},
    "explorer.md": {"slide.html": "html"},
}
_SMALL = "tilt=0.1deg:4deg:9 roll_rate=2:4:12"
_TOY = "tilt=60deg:85deg:6 contour_friction=1um:30um:7:log rolling_friction=15um precession_rate=wobble"
#: Commands that create what a page assumes to exist.
BEFORE = {
    "runs.md": ["batch sweeps/two.toml -o trusted"],
    "explorer.md": ["run rolling alpha=1 roll_rate=1:4:9 tilt=1deg:5deg:8 -o hoop.nc"],
    "figures.md": [
        f"run rolling {_SMALL} -o rolling.nc",
        f"run rolling {_SMALL} alpha=0.2,0.5,1 -o alphas.nc",
        f"run toy {_TOY} -o toy.nc",
    ],
}
#: Python that defines the names that a page assumes to exist.
NAMES = {"figures.md": "import sweep\natlas = sweep.open_atlas('rolling.nc')"}
#: Commands that appear in the comment of a file on a page.
AFTER = {"commands.md": ["run pushed.toml -o pushed.nc"]}
#: Sizes that can be smaller without changing the outcome.
SMALLER = {"samples=1e5": "samples=1e3", "samples=2e5": "samples=2e3", ":100:log": ":9:log", ":200": ":40"}
#: Patterns in the output of a page's commands and Python.
TOLD = {
    "api.md": r"criterion  departure:5deg(.|\n)*computing: 100% of 2000 cells",
    "runs.md": r"^hoop .*identical",
    "own-system.md": r"^35\.8487\d*$",
    "index.md": r"^2\.5\d+ 2\.5\d+$",
    "starts.md": r"^1 of 2$",
    "words.md": r"^16\.[45]\d*$",
}

#: Commands in sentences -> small commands that create the files they read.
_GRID = "tilt=1deg:3deg:3 roll_rate=2:4:6"
_RANDOM = "run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=200 seed=7 -o random.nc"
_PUSHED = "prepare rolling --starts pushes.csv -o pushes.nc"
NEEDS = {
    "plot three.nc alpha=0.5 -o slice.png": [f"run rolling alpha=0.2,0.5 {_GRID} -o three.nc"],
    "boundary three.nc alpha=0.5 -o slice.nc": [f"run rolling alpha=0.2,0.5 {_GRID} -o three.nc"],
    "boundary a.nc --to csv": [f"run rolling {_GRID} -o a.nc"],
    "export a.nc --to csv": [f"run rolling {_GRID} -o a.nc"],
    "info fall.nc": ["simulate radius=12mm tilt=1deg duration=2s -o fall.nc"],
    "run --from pushes.nc": ["run rolling --starts pushes.csv -o pushes.nc"],
    "block --run pushes.nc.run --part 1/1": [_PUSHED],
    "assemble pushes.nc.run": [_PUSHED, "block --run pushes.nc.run --part 1/1"],
    "plot random.nc start=0:99 -o part.png": [_RANDOM],
    "simulate --from random.nc start=17": [_RANDOM],
    "run --from random.nc start=0:99": [_RANDOM],
    "run --from atlas.nc radius=12mm": [f"run rolling {_GRID} -o atlas.nc"],
    "plot speeds.nc speed=18cm/s:25cm/s -o part.png": [
        "run rolling speed=15cm/s:30cm/s:9 radius=12mm tilt=1deg:3deg:3 -o speeds.nc"
    ],
}
PROGRAM = "run|plan|batch|plot|info|boundary|verify|compare|explain|simulate|export"


def blocks(page):
    """Return language and text of a page's code blocks, except Sphinx directives and other tests' blocks."""
    found = re.findall(r"^```(\S*)\n(.*?)^```$", PAGES[page].read_text(encoding="utf-8"), re.M | re.S)
    others, _ = ELSEWHERE.get(page, (set(), ""))
    return [(language, text) for language, text in found if language.isalpha() and language not in others]


def is_read_only(page, text):
    """Return whether a block's commands take minutes and are therefore not run."""
    return page in READ_ONLY and READ_ONLY[page] in text


def lines(text):
    """Return the commands of a bash block, without comments and the program's name."""
    found = [re.sub(r"(^|\s+)#.*", "", each).strip() for each in text.splitlines()]
    return [each.removeprefix("eulerdisk ") for each in found if each]


def in_sentences():
    """Yield page and command of each command in the pages' sentences and tables."""
    begins = rf"eulerdisk |(?:{PROGRAM}) [^ ]|(?:pip|python|pytest|source|cp) |scripts/\w"
    for page, path in PAGES.items():
        text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
        spans = [" ".join(each.split()) for each in re.findall(r"`([^`]+)`", text)]
        found = dict.fromkeys(each.removeprefix("eulerdisk ") for each in spans if re.match(begins, each))
        yield from ((page, each) for each in found)


def stands_for_many(line):
    """Return whether a command is only named, at most with an option."""
    return re.search(r"\.\.\.|\b[A-Z]{2,}\b", line) or not re.search(r"=|\.nc\b", line)


@pytest.fixture
def run(command):
    """Return a function that runs a command line, which must succeed and write the files it names."""

    def run(page, line):
        if line.startswith("explore ") or line == "explore":
            return explored(line)
        words = [each for word in shlex.split(line) for each in sorted(glob.glob(word)) or [word]]
        status, out, err = command(shlex.join(words))
        assert status == 0, (page, line, err)
        for option in ("-o", "--plot", "--animate"):
            if option in words and words[0] != "prepare":
                made = Path(words[words.index(option) + 1])
                assert made.is_dir() or made.stat().st_size > 0, (page, line)
        return out

    return run


def explored(line):
    """Start the explorer and stop it after its first answer, or write its page."""
    words = [sys.executable, "-m", "sweep", *shlex.split(line)]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    if "--export" in words:
        subprocess.run(words, env=environment, check=True, capture_output=True)
        assert Path(words[-1]).stat().st_size > 1e6
        return ""
    words.append("--no-browser")
    with subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, text=True) as running:
        assert ask(running.stdout.readline().strip()).status == 200
        running.send_signal(2)
    assert running.returncode == 0
    return ""


def test_no_block_escapes():
    """These tests, or another existing test, cover the language of each block."""
    for page in PAGES:
        others = {language for language, _ in blocks(page)} - {"bash", "python", "text"}
        assert others <= set(FILES.get(page, {}).values()), (page, others)
    assert all((CHECKOUT / test).is_file() for _, test in ELSEWHERE.values())
    assert {each for _, each in in_sentences()} >= NEEDS.keys()


#: Pages that take 20 s or more: they run with the release; otherwise their commands are only parsed.
LONG = ("bodies.md", "commands.md", "figures.md", "own-system.md")


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(each, marks=pytest.mark.release if each in LONG else [])
        for each in PAGES
        if any(not is_read_only(each, text) for _, text in blocks(each))
    ],
)
def test_the_blocks_of_a_page_run(page, run, command, capsys):
    """Blocks run in page order, in one folder: commands succeed, Python raises nothing, output matches."""
    found = [each for each in blocks(page) if not is_read_only(page, each[1])]
    told, names = "", {"__name__": page}
    for name, language in FILES.get(page, {}).items():
        Path(name).parent.mkdir(exist_ok=True)
        (text,) = (each for kind, each in found if kind == language)
        Path(name).write_text(smaller(text), encoding="utf-8")
    with lossy_runner.general_kernels():
        for line in BEFORE.get(page, []):
            run(page, line)
    exec(NAMES.get(page, ""), names)
    for language, text in found:
        if language == "text":
            line, _, said = text.removeprefix("$ eulerdisk ").partition("\n")
            status, _, err = command(line)
            assert (status, err) == (2, said)
        elif language == "python":
            # A system is read from its source.
            linecache.cache[page] = len(text), None, text.splitlines(keepends=True), page
            exec(compile(text, page, "exec"), names)
            told += capsys.readouterr().out
        elif language == "bash" and not text.startswith("#!"):
            told += "".join(run(page, smaller(line)) for line in lines(text) if not line.startswith(NOT_RUN))
    for line in AFTER.get(page, []):
        run(page, line)
    pyplot.close("all")
    assert re.search(TOLD.get(page, ""), told, re.M), told
    if page == "index.md":
        # The measured rate is less than two percent below the critical one.
        measured, critical = map(float, re.search(TOLD[page], told, re.M)[0].split())
        assert 0.98 * critical < measured < critical
        # The published value, and the last digits printed on the page.
        assert 3 * float(told.splitlines()[-1]) == pytest.approx(1.0, abs=3e-5)
        assert f"# {float(told.splitlines()[-1]):.6f}\n" in found[-1][1]


def smaller(text):
    """Return a text with smaller sizes."""
    for old, new in SMALLER.items():
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("page", [*READ_ONLY, *LONG])
def test_what_a_page_asks_for_can_be_had(page, command, monkeypatch):
    """Scripts exist, words can be parsed, and options are known."""
    monkeypatch.setattr("shutil.which", lambda name: name)
    asked = [
        line
        for language, text in blocks(page)
        if language == "bash" and (page in LONG or is_read_only(page, text))
        for line in lines(text)
        if page not in LONG or not (line.startswith(NOT_RUN) or stands_for_many(line))
    ]
    assert asked
    for line in asked:
        first, *rest = shlex.split(line.removeprefix("python -m sweep "))
        if first == "python":
            assert (CHECKOUT / rest[0]).is_file(), line
            continue
        told = command(f"{first} --help")[1]
        assert [word for word in rest if word.startswith("--") and word not in told] == [], line
        given = [word for word in rest if "=" in word]
        if page in LONG:
            # Its words may name files that earlier commands create.
            continue
        if first == "run":
            SweepSpec.from_words(rest[0], given)
        elif first == "simulate" and is_preset(rest[0]):
            request_of_preset(rest[0], split_motion_words(given))
        elif first == "simulate":
            TrajectorySpec.from_words(given)
        else:
            assert first in ("plot", "export")
        if page == "motions.md" and first == "simulate":
            options = dict(pairwise(rest))
            film = {
                name: options[f"--{name}"] for name in ("size", "fps", "camera") if f"--{name}" in options
            }
            film |= {"fps": int(film["fps"])} if "fps" in film else {}
            FilmOptions.read(options["--animate"], **film)


def test_named_commands_and_their_options_are_known(command):
    """For `eulerdisk plot --friction 0.5` in a sentence, command and option exist."""
    for page, line in in_sentences():
        first, *words = line.split()
        script = re.search(r"scripts/[\w/]+(?:\.py)?", line)
        assert not script or (CHECKOUT / script[0]).is_file(), (page, line)
        if line.startswith(NOT_RUN) or not stands_for_many(line):
            continue
        if first.startswith("-"):
            assert command(first)[0] == 0, (page, line)
            continue
        status, told, _ = command(f"{first} --help")
        assert status == 0, (page, line)
        assert [word for word in words if word.startswith("--") and word not in told] == [], (page, line)


@pytest.mark.release
def test_commands_of_sentences_run(run, tmp_path, monkeypatch):
    """Each succeeds in its own folder and writes the file it names."""
    asked = [each for each in in_sentences() if not (stands_for_many(each[1]) or each[1].startswith(NOT_RUN))]
    assert len(asked) > 10
    for number, (page, line) in enumerate(asked):
        folder = tmp_path / str(number)
        folder.mkdir()
        monkeypatch.chdir(folder)
        Path("pushes.csv").write_text("roll_rate [rad/s],tilt [deg]\n2.5,1.0\n3.1,0.5\n", encoding="utf-8")
        for each in NEEDS.get(line, []):
            run(page, each)
        writes = line.startswith(("run ", "simulate ")) and "-o" not in line and "--help" not in line
        run(page, f"{line} -o made.nc" if writes else line)


def test_every_command_is_shown(command):
    """docs/commands.md shows every command, except array jobs and the explorer, which have own pages."""
    listed = command("--help")[1].partition("Commands:")[2].splitlines()[1:]
    known = {each.split()[0] for each in listed}
    assert len(known) > 10
    shown = re.findall(r"eulerdisk ([a-z]+)", PAGES["commands.md"].read_text(encoding="utf-8"))
    assert known - set(shown) <= {"prepare", "block", "assemble", "explore"}
    # Each has an uncut sentence on one line.
    assert [line for line in listed if not re.fullmatch(r"  [a-z]+ +[A-Z].*[^.]\.", line)] == []
