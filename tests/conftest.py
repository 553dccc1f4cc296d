"""Settings for every test: the same examples each time, the same terminal everywhere, no window."""

import fcntl
import os
import random
import secrets
import shlex
import signal
import sys
import zlib

import numpy as np
import pytest
from hypothesis import settings
from whole_run import WholeRun

from sweep import platforms
from sweep.model import space_sample
from sweep.model.system import sample

# Compiling the first kernel takes seconds; hypothesis would charge them to a single example.
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("fresh", deadline=None)
settings.load_profile("same")

os.environ["MPLBACKEND"] = "agg"

# A process whose files may only be small, as in tests of a full disk, would leave byte code that ends too early.
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"

# A shell that starts the tests in the background makes them, and all processes they start, ignore interrupts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Tests read what the commands print: no colors, and lines as wide as any message.
for name in ("FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS"):
    os.environ.pop(name, None)
os.environ.update(NO_COLOR="1", TERM="dumb", COLUMNS="200")

# `verify` follows its minimum of cells by another method, however fast the machine is.
space_sample.SECONDS = sample.SECONDS = 0.0

# Earlier tests decide which command compiles a kernel, and the machine decides which one is slow: show no notices.
os.environ["EULERDISK_NOTICES"] = "no"


def pytest_addoption(parser):
    """Add the options for other examples and random numbers."""
    parser.addoption("--seed", type=int, default=0, help="draw other random numbers and examples than by day")
    fresh = {"action": "store_const", "const": secrets.randbits(32), "dest": "seed"}
    parser.addoption("--fresh-seeds", **fresh, help="the same, with a seed that is drawn and told")
    pretend = (
        "answer so where the program asks its machine, e.g. free_bytes=2e9 or processors=16 (sweep.platforms)"
    )
    parser.addoption("--pretend", action="append", default=[], metavar="NAME=NUMBER", help=pretend)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Register the whole-run plugin, and give hypothesis the seed, if any."""
    config.pluginmanager.register(WholeRun(config))
    if config.option.seed:
        settings.load_profile("fresh")
        config.option.hypothesis_seed = config.option.seed


def pytest_collection_modifyitems(config, items):
    """Start with the slow lane, so that no process ends with a long test; shuffle if there is a seed."""
    if config.option.seed:
        # Shuffle by file, because most fixtures serve one file.
        dice, names = random.Random(config.option.seed), sorted({str(item.path) for item in items})
        place = {name: dice.random() for name in names}
        dice.shuffle(items)
        items.sort(key=lambda item: place[str(item.path)])
    items.sort(key=lambda item: item.get_closest_marker("slow_lane") is None)


@pytest.fixture
def rng(request):
    """Return a random number generator, the same in each run of a test unless --seed is given."""
    return np.random.default_rng([zlib.crc32(request.node.nodeid.encode()), request.config.option.seed])


@pytest.fixture
def count(request):
    """Return a function that selects the number of examples: the first by default, the second with another seed."""
    return lambda by_day, fresh: fresh if request.config.option.seed else by_day


@pytest.fixture
def pick(request):
    """Return a function that picks at most so many cases, evenly spread; with another seed it picks all."""

    def choose(cases, by_day):
        cases = list(cases)
        return cases if request.config.option.seed else cases[:: -(-len(cases) // by_day)]

    return choose


@pytest.fixture
def machine(monkeypatch):
    """Return a function that replaces functions of `sweep.platforms`, given by name, with fixed numbers."""

    def answer(**answers):
        for name, number in answers.items():
            monkeypatch.setattr(platforms, name, lambda *_, number=number: number)

    return answer


@pytest.fixture
def two_threads(monkeypatch):
    """Let runs use two threads, even on a machine with one processor."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")


@pytest.fixture(scope="session", autouse=True)
def pretended(request):
    """Let this test process see another machine, if requested."""
    with pytest.MonkeyPatch.context() as patch:
        for name, _, number in (each.partition("=") for each in request.config.option.pretend):
            answer = float(number)
            answer = int(answer) if answer.is_integer() else answer
            patch.setattr(platforms, name, lambda *_, answer=answer: answer)
        yield


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Return a function that returns a named folder, created by the first test process that requests it."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def made(name, make):
        with open(shared / f"{name}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (shared / name).exists():
                make(base / f"{name}.part")
                (base / f"{name}.part").rename(shared / name)
        return shared / name

    return made


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Return a function that runs a command line in an empty folder and returns status, output and messages."""
    from sweep import cli

    monkeypatch.chdir(tmp_path)

    def run(line):
        monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(line)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return end.value.code, *capsys.readouterr()

    return run


@pytest.fixture
def spec_file(tmp_path):
    """Return a function that writes a spec file and returns its path."""

    def write(text, name="sweep.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def crowd():
    """Return random starts over all parameters, with their exact extremes."""
    import kernel_runner
    import referee

    given = kernel_runner.scattered(1500, seed=5)
    return given, referee.extremes(given)
