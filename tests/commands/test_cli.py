"""The command line: refusals, exit statuses, and the modules it loads."""

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
from messages import assert_facts

import sweep
from sweep import cli
from sweep.errors import FailedBlocksError, RequestError, StorageError

CHECKOUT = Path(__file__).parents[2]
SLOW_TO_LOAD = {"numba", "llvmlite", "xarray", "netCDF4", "scipy", "matplotlib", "pandas"}


def test_a_request_that_this_machine_cannot_meet_has_one_message(command, machine, tmp_path):
    """A request beyond this machine gives status 2 and one line, and nothing is written."""
    machine(free_bytes=50e9, processors=2)
    for line, facts in (
        ("run rolling roll_rate=0:9:30000 tilt=0:1:33000 -o a.nc", ["50 GB", "a.nc"]),
        ("run rolling roll_rate=3 tilt=1deg --threads 0 -o a.nc", ["threads", "1 to 2", "0"]),
    ):
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert err.startswith("eulerdisk: ")
        assert_facts(err, *facts)
        assert list(tmp_path.iterdir()) == []


def numbers():
    """Return each command and option that takes a number."""
    found = []
    for name, (module, _) in cli._COMMANDS.items():
        function = getattr(import_module(f"sweep.commands.{module}"), name)
        for parameter, annotation in get_type_hints(function).items():
            if {int, float} & {annotation, *get_args(annotation)}:
                found.append((name, "--" + parameter.replace("_", "-")))
    return found


@pytest.mark.parametrize(("name", "option"), numbers())
def test_every_option_that_is_a_number_refuses_others(command, name, option):
    """Every numeric option refuses other digits, because all use the reader in `sweep.commands.arguments`."""
    status, _, err = command(f"{name} a.nc {option} ٣")
    assert status == 2
    assert_facts(err, f"'{option}'", "'٣'")


def test_no_command_at_all_shows_the_help(command):
    """`eulerdisk` without a command lists the commands and exits with 2."""
    status, out, err = command("")
    assert status == 2
    assert "Commands:" in out + err


def test_a_key_press_that_ends_it(command, monkeypatch):
    """Ctrl-C before anything is kept exits with 130 and without a traceback."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", interrupted)
    told = "eulerdisk: interrupted; no unfinished file was written.\n"
    assert command("run rolling -o a.nc") == (130, "", told)


def test_cells_without_a_verdict_are_mentioned(command):
    """A run with mostly undecided cells states their number and the command that explains them; others are silent."""
    status, _, told = command("run rolling tilt=1deg roll_rate=3:4:5 duration=0.01s -o short.nc")
    assert status == 0
    assert_facts(told, "5 of 5 cells", "undecided", "eulerdisk explain")
    assert "undecided" not in command("run rolling tilt=1deg roll_rate=3:4:5 -o long.nc")[2]


def test_a_rim_has_no_upright_motion(command):
    """A run of an upright rim says so and names presets with a motion to disturb; others are silent."""
    rim = "body=rim thickness=0.2"
    status, _, told = command(f"run rolling {rim} tilt=1deg roll_rate=3:4:5 -o rim.nc")
    assert status == 0
    assert_facts(told, "5 of 5 cells", "upright", "thick_coin", "true_edge", "torus")
    others = (
        f"rolling {rim} tilt=40deg precession_rate=3:4:5 roll_rate=steady",
        "torus tube=0.2 scaled_roll_rate=0.5:0.6:5",
        "rolling tilt=1deg roll_rate=3:4:5 duration=0.01s",
    )
    for line in others:
        status, _, told = command(f"run {line} -o other.nc --overwrite")
        assert status == 0
        assert "thick_coin" not in told


@pytest.mark.parametrize(("kind", "status"), [(RequestError, 2), (StorageError, 3), (FailedBlocksError, 1)])
def test_each_error_has_its_exit_status(command, monkeypatch, kind, status):
    """The command exits with the error's status and prints the error on one line."""

    def refuse(*_, **__):
        raise kind("The disk must have room; got none.", "Free 2 GB.", "a.nc")

    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", refuse)
    message = "eulerdisk: a.nc: The disk must have room; got none. Free 2 GB.\n"
    assert command("run rolling -o a.nc") == (status, "", message)


def test_a_defect_is_not_hidden(command, monkeypatch):
    """An unexpected error keeps its traceback and has its own status."""
    monkeypatch.setattr("sweep.request.spec.SweepSpec.from_words", lambda *_: 1 / 0)
    status, out, err = command("run rolling -o a.nc")
    assert (status, out) == (70, "")
    assert "ZeroDivisionError: division by zero\n" in err


def test_version(command):
    """`--version` prints the package's version."""
    assert command("--version") == (0, f"eulerdisk {sweep.__version__}\n", "")


@pytest.mark.slow_lane
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
    """Help, plans and refused requests load no compiler, file or figure library."""
    (tmp_path / "a.nc").write_text("old")
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "sweep", *line.split()],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    lines = [line for line in done.stderr.splitlines() if line.startswith("import time:")]
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in lines}
    assert done.returncode == status
    assert {"typer", "sweep"} <= loaded
    assert loaded & SLOW_TO_LOAD == set()


def test_help_loads_no_numpy(tmp_path):
    """`eulerdisk --help` loads neither numpy nor pydantic."""
    code = "import sys, sweep.cli; print(*{'numpy', 'pydantic', 'rich'} & {n.partition('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "\n"


def test_the_package_loads_light():
    """`import sweep` and a spec load none of the heavy libraries."""
    code = "import sys, sweep; sweep.SweepSpec.preset('rolling'); print(*{n.partition('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert set(done.stdout.split()) & SLOW_TO_LOAD == set()
    assert sweep.__name__ in done.stdout
