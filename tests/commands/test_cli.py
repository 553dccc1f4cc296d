"""The command line: refusals, exit statuses, and what is loaded before the work begins."""

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

import sweep
from sweep import cli
from sweep.errors import FailedBlocksError, RequestError, StorageError

CHECKOUT = Path(__file__).parents[2]
SLOW_TO_LOAD = {"numba", "llvmlite", "xarray", "netCDF4", "scipy", "matplotlib", "pandas"}


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("run rolling rol_rate=3 -o a.nc", ["rol_rate", "tilt", "Did you mean roll_rate?"]),
        ("run roling -o a.nc", ["roling", "spinning", "circling", "Did you mean rolling?"]),
        ("run rolling roll_rate=3deg -o a.nc", ["'deg'", "rad/s", "roll_rate=3deg"]),
        ("run rolling tilt=3m -o a.nc", ["'m'", "deg", "rad", "tilt=3m"]),
        ("run rolling roll_rate=4:2:9 -o a.nc", ["roll_rate", "4:2:9", "smaller end first"]),
        ("run rolling roll_rate=2:4:0 -o a.nc", ["roll_rate", "2:4:0", "count >= 1"]),
        ("run rolling roll_rate= -o a.nc", ["roll_rate=", "a number, a list", "0.01deg:20deg:300:log"]),
        ("run rolling roll_rate=2:inf:9 -o a.nc", ["roll_rate", "2:inf:9", "finite"]),
        ("run rolling tilt=nan -o a.nc", ["tilt=nan", "finite"]),
        ("run rolling alpha=0 -o a.nc", ["0 < alpha <= 1", "alpha=0"]),
        ("run rolling alpha=0.5,1.5 -o a.nc", ["1.5", "0 < alpha <= 1", "alpha=0.5,1.5"]),
        ("run rolling radius=0 -o a.nc", ["radius > 0", "radius=0"]),
        ("run rolling gravity=-9.81 -o a.nc", ["gravity > 0", "gravity=-9.81"]),
        ("run rolling tilt=0:90deg:9 -o a.nc", ["90 deg", "|tilt| < 90 deg", "0:90deg:9"]),
        ("run rolling tilt=20 -o a.nc", ["20 rad", "|tilt| < 1.570796326 rad", "tilt=20", "tilt=20deg"]),
        ("run circling precession_rate=0 -o a.nc", ["precession", "other than 0", "steady"]),
        ("run rolling criterion=depart -o a.nc", ["criterion", "depart", "departure:5deg"]),
        ("run rolling 'criterion=peek_tilt > 1' -o a.nc", ["criterion=peek_tilt > 1", "character 1:", "peak_tilt?"]),
        ("run rolling 'criterion=wells == two_wells' -o a.nc", ["wells", "Add method=exact"]),
        ("plan rolling 'criterion=fall_time < 2s' method=exact", ["fall_time", "method=rk4"]),
        ("run rolling tilt=1deg tilt=2deg -o a.nc", ["tilt=1deg and tilt=2deg"]),
        ("run rolling roll_rate=0:9:30000 tilt=0:1:33000 -o a.nc", ["GB", "free"]),
        ("run rolling roll_rate=0:9:10000000 tilt=0:1:900000 -o a.nc", ["at most 1000000000 cells", "x 900000"]),
        ("run rolling -o missing/a.nc", ["missing", "no such folder", "mkdir -p missing"]),
        ("run rolling -o .", ["not a file", "file name"]),
        ("run rolling roll_rate=3 tilt=1deg --threads 0 -o a.nc", ["threads", "from 1 to", "got 0"]),
        ("run missing.toml -o a.nc", ["missing.toml", "No such file"]),
        ("run -o a.nc", ["SPEC", "--from", "eulerdisk run rolling"]),
        ("run rolling --from a.nc -o b.nc", ["SPEC", "rolling", "--from a.nc", "not both"]),
        ("block --run a.nc.run --part 3/2", ["--part", "I/N", "3/2"]),
        ("info missing.nc", ["missing.nc", "no such file"]),
        ("info missing.nc --partial b.nc", ["missing.nc", "--partial", "no unfinished run"]),
        ("boundary missing.nc", ["missing.nc", "no such file"]),
        ("plot missing.nc -o a.png", ["missing.nc", "no such file"]),
        ("plot missing.nc --friction -1 -o a.png", ["--friction", "greater than 0", "-1", "--friction 0.5"]),
        ("plot missing.nc --regimes --friction 1 -o a.png", ["--regimes", "--friction", "Leave --friction out"]),
        ("simulate tilt=1deg -o path.csv", [".nc", ".png", ".mp4", "path.csv", "-o path.nc"]),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)  # fmt: skip
def test_a_bad_request_has_one_message(command, tmp_path, line, facts):
    """It ends with 2 and one line on standard error that names key, limit, value and remedy; nothing is touched."""
    status, out, err = command(line)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("eulerdisk: ")
    for fact in facts:
        assert fact in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("rnu rolling", ["rnu", "eulerdisk --help", "run"]),
        ("frob", ["frob", "eulerdisk --help"]),
        ("--vresion", ["--vresion", "--version", "eulerdisk --help"]),
        ("run rolling --thread 2 -o a.nc", ["--thread ", "--threads", "eulerdisk run --help"]),
        ("run rolling --qqq -o a.nc", ["--qqq", "eulerdisk run --help"]),
        ("run", ["--output", "-o", "eulerdisk run --help"]),
        ("export a.nc", ["--to", "eulerdisk export --help"]),
        ("info", ["Missing", "ATLAS.nc", "eulerdisk info --help"]),
        ("plot -o a.png", ["Missing", "ATLAS.nc", "eulerdisk plot --help"]),
        ("compare a.nc", ["Missing", "REFERENCE.nc", "eulerdisk compare --help"]),
        ("run rolling -o", ["-o", "argument"]),
        ("run rolling --overwrite=3 -o a.nc", ["--overwrite", "value"]),
        ("info a.nc b.nc", ["b.nc", "eulerdisk info --help"]),
        ("run rolling --threads two -o a.nc", ["--threads", "integer", "eulerdisk run --help"]),
        ("run rolling --max-failed=x -o a.nc", ["--max-failed", "valid", "eulerdisk run --help"]),
        ("run rolling --max-failed nan -o a.nc", ["--max-failed", "0 to 100", "nan"]),
        ("run rolling --max-failed -1 -o a.nc", ["--max-failed", "0 to 100", "-1"]),
        ("assemble a.nc.run --max-failed 101", ["--max-failed", "0 to 100", "101"]),
        ("verify a.nc --seed -1", ["--seed", "0 or more", "-1"]),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_the_parser_names_what_it_refuses(command, tmp_path, line, facts):
    """A wrong command, argument or option ends with 2 and is named, with the help to read; nothing is touched."""
    status, out, err = command(line)
    assert (status, out) == (2, "")
    assert "Traceback" not in err
    for fact in facts:
        assert fact in err
    assert list(tmp_path.iterdir()) == []


def numbers():
    """Return command and option wherever a command takes a number."""
    found = []
    for name, (module, _) in cli._COMMANDS.items():
        function = getattr(import_module(f"sweep.commands.{module}"), name)
        for parameter, annotation in get_type_hints(function).items():
            if {int, float} & {annotation, *get_args(annotation)}:
                found.append((name, "--" + parameter.replace("_", "-")))
    return found


@pytest.mark.parametrize(("name", "option"), numbers())
def test_every_option_that_is_a_number_refuses_others_in_the_same_words(command, name, option):
    """So does one that is added: no other reader of numbers than that of `sweep.commands.arguments`."""
    status, _, err = command(f"{name} a.nc {option} ٣")
    assert status == 2
    assert "'٣' is not a valid" in err


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("help", "Write eulerdisk --help."),
        ("hlep", "Write eulerdisk --help."),
        ("help plot", "Write eulerdisk plot --help."),
        ("help me", "Write eulerdisk --help."),
        ("version", "Write eulerdisk --version."),
        ("runn", "Did you mean run? See eulerdisk --help for what each of them does."),
        ("PLOT a.nc", "Did you mean plot? See eulerdisk --help for what each of them does."),
        ("rolling", "See eulerdisk --help for what each of them does."),
        ("''", "See eulerdisk --help for what each of them does."),
    ],
)
def test_a_word_that_is_no_command(command, line, hint):
    """The commands are named, with the one that was probably meant; `help` is an option here."""
    status, out, err = command(line)
    assert (status, out) == (2, "")
    assert "; commands are run, plan, batch, plot, info," in err
    assert err.endswith(f"{hint}\n")
    assert len(err.splitlines()) == 1


def test_a_misspelt_option_is_told_with_the_right_one(command):
    """`--hlep` is refused with `--help`."""
    status, _, err = command("run --hlep")
    assert status == 2
    assert "--help" in err.splitlines()[-1]


def test_no_command_at_all_shows_the_help(command):
    """`eulerdisk` alone lists the commands and ends with 2."""
    status, out, err = command("")
    assert status == 2
    assert "Commands:" in out + err


def test_a_key_press_that_ends_it(command, monkeypatch):
    """Ctrl-C where nothing is kept ends with 130 and without a traceback."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", interrupted)
    told = "eulerdisk: interrupted; no unfinished file was written.\n"
    assert command("run rolling -o a.nc") == (130, "", told)


@pytest.mark.parametrize(("kind", "status"), [(RequestError, 2), (StorageError, 3), (FailedBlocksError, 1)])
def test_each_error_has_its_exit_status(command, monkeypatch, kind, status):
    """The command ends with the status of the error, and prints it on one line."""

    def refuse(*_, **__):
        raise kind("The disk must have room; got none.", "Free 2 GB.", "a.nc")

    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", refuse)
    message = "eulerdisk: a.nc: The disk must have room; got none. Free 2 GB.\n"
    assert command("run rolling -o a.nc") == (status, "", message)


def test_a_defect_is_not_hidden(command, monkeypatch):
    """An error that is not a bad request keeps its traceback, and has a status of its own."""
    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", lambda *_: 1 / 0)
    status, out, err = command("run rolling -o a.nc")
    assert (status, out) == (70, "")
    assert "ZeroDivisionError: division by zero\n" in err


def test_version(command):
    """The version is that of the package."""
    assert command("--version") == (0, f"eulerdisk {sweep.__version__}\n", "")


@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("--help", 0),
        ("warmup --help", 0),
        ("plan rolling --no-calibrate", 0),
        ("rnu rolling", 2),
        ("run rolling --thread 2 -o b.nc", 2),
        ("run roling -o b.nc", 2),
        ("run rolling rate=1 -o b.nc", 2),
        ("run rolling tilt=1:2:0 -o b.nc", 2),
        ("run rolling tilt=95deg -o b.nc", 2),
        ("run rolling device=gpu -o b.nc", 2),
        ("run rolling -o missing/b.nc", 2),
        ("run rolling -o a.nc", 2),
        ("run missing.toml -o b.nc", 2),
        ("info missing.nc", 2),
        ("verify missing.nc", 2),
        ("plot missing.nc -o b.png", 2),
        ("plot a.nc -o b.gif", 2),
    ],
)
def test_what_needs_nothing_heavy_loads_nothing_heavy(tmp_path, line, status):
    """Help, a plan, and every request that words and file names refuse load no compiler, file or figure library."""
    (tmp_path / "a.nc").write_text("old")
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "sweep", *line.split()],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    lines = [line for line in done.stderr.splitlines() if line.startswith("import time:")]
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in lines}
    assert done.returncode == status
    assert {"typer", "sweep"} <= loaded
    assert loaded & SLOW_TO_LOAD == set()


def test_help_loads_no_numpy(tmp_path):
    """`eulerdisk --help` waits for neither numpy nor pydantic."""
    code = "import sys, sweep.cli; print(*{'numpy', 'pydantic', 'rich'} & {n.partition('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "\n"


def test_the_package_loads_light():
    """`import sweep` and a spec load none of the heavy libraries either."""
    code = "import sys, sweep; sweep.SweepSpec.preset('rolling'); print(*{n.partition('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert set(done.stdout.split()) & SLOW_TO_LOAD == set()
    assert sweep.__name__ in done.stdout
