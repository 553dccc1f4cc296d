"""A ten-line system can do all that the disk can: each ability works or is refused in a sentence."""

import base64
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
import zlib
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, refused, row

import sweep
from sweep.checks.compare import compare
from sweep.engine.compute import arithmetic_hash
from sweep.figures import plots
from sweep.request.system_file import read_system_file

pytestmark = pytest.mark.compiled

CHECKOUT = Path(__file__).parents[2]
BEAD = CHECKOUT / "tests" / "models" / "bead.py"
GRID = "hoop_rate=4:5:21 angle=0.1deg:4deg:7:log"
OTHER = """
@system(duration="1 s")
def other(x: "m" = 1.0, *, k: "1/s" = 1.0):
    return -k*x
"""
WORDS = {"hoop_rate": "4:5:21", "angle": "0.1deg:4deg:7:log"}


@pytest.fixture(autouse=True)
def mine(tmp_path, monkeypatch):
    """Change to an empty folder with the system's file, as a user has it."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(BEAD, tmp_path / "mine.py"))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return an atlas of the system."""
    path = tmp_path_factory.mktemp("made") / "a.nc"
    sweep.run_to_file(str(BEAD), path, **WORDS)
    return path


def bits(path):
    """Return the values of all variables of a file as bytes."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        return {name: variable[...].tobytes() for name, variable in file.variables.items()}


@pytest.mark.slow_lane
def test_run_and_what_an_atlas_says(command, made):
    """The command and Python compute the same cells; the atlas has the system's title and edge."""
    status, _, told = command(f"run mine.py {GRID} -o a.nc")
    assert status == 0
    assert_facts(told, "a.nc", "147 cells")
    assert bits("a.nc") == bits(made)
    with sweep.open_atlas("a.nc") as atlas:
        assert list(atlas.sizes.items())[:2] == [("hoop_rate", 21), ("angle", 7)]
        assert set(np.unique(atlas.stability)) == {1, 2}
        # The title is the system's docstring.
        assert atlas.attrs["title"].startswith("Bead on a turning hoop")
        assert float(atlas.critical_lower_hoop_rate[0]) == pytest.approx(np.sqrt(9.81 / 0.5))


@pytest.mark.slow_lane
@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("info", ["stable below hoop_rate", "errors", "lowest"]),
        ("boundary", ["critical_lower_hoop_rate"]),
        ("verify", ["verified", "147 of 147 cells", "DOP853"]),
        ("explain a.nc hoop_rate=4.4 angle=1deg", ["repeated", "bit for bit"]),
        ("export a.nc --to csv", []),
        ("plot a.nc -o a.png", []),
        ("plot a.nc --quantity ending -o e.png", []),
        ("plot a.nc angle=1deg -o slice.png", []),
    ],
)
def test_what_is_read_needs_no_file_of_the_system(words, told, command, made, mine):
    """An atlas contains its system: everything that reads it works without the .py file."""
    mine.unlink()
    shutil.copy(made, "a.nc")
    status, output, messages = command(words if "a.nc" in words else f"{words} a.nc")
    assert status == 0, messages
    assert_facts(output, *told)
    if " -o " in words:
        assert Path(words.rpartition(" ")[2]).stat().st_size > 10_000


def test_an_atlas_is_computed_again_without_the_file(command, made, mine):
    """`run --from` gives the same cells; with another radius the critical rate follows; compare agrees."""
    mine.unlink()
    shutil.copy(made, "a.nc")
    assert command("run --from a.nc -o b.nc")[0] == 0
    assert_facts(command("compare b.nc a.nc")[1], "identical", "147 cells")
    assert command("run --from a.nc radius=0.6m -o c.nc")[0] == 0
    assert command("compare c.nc a.nc")[0] != 0
    with sweep.open_atlas("c.nc") as atlas:
        assert float(atlas.critical_lower_hoop_rate[0]) == pytest.approx(np.sqrt(9.81 / 0.6))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("plot --regimes a.nc -o r.png", ["bead", "--regimes"]),
        ("plot --losses a.nc -o r.png", ["bead", "--losses"]),
        ("plot --friction 0.3 a.nc -o r.png", ["bead", "contact forces"]),
        ("run mine.py roll_rate=3 -o b.nc", ["roll_rate", "hoop_rate"]),
        ("run mine.py method=exact -o b.nc", ["method", "taylor", "exact"]),
        ("run mine.py criterion=departure:5deg -o b.nc", ["criterion", "departure:5deg"]),
        ("run mine.py:hoop -o b.nc", ["mine.py", "hoop", "bead"]),
        ("run gone.py -o b.nc", ["gone.py"]),
    ],
)
def test_what_it_lacks_is_said_in_a_sentence(words, told, command, made):
    """It is refused with status 2, in one line, and nothing is written."""
    shutil.copy(made, "a.nc")
    status, out, messages = command(words)
    assert (status, out, messages.count("\n")) == (2, "", 1), messages
    assert_facts(messages, *told)
    assert not Path("b.nc").exists()
    assert not Path("r.png").exists()


def test_plan_and_batch(command):
    """`plan` computes nothing; `batch` runs sweeps whose model is a file next to the spec."""
    status, told, _ = command(f"plan mine.py {GRID} --no-calibrate")
    assert (status, row(told, "cells").split()[1]) == (0, "147")
    Path("two.toml").write_text(
        'model = "mine.py"\n[[sweep]]\nname = "slow"\nhoop_rate = "2:4:5"\n'
        '[[sweep]]\nname = "fast"\nhoop_rate = "5:6:5"\n'
    )
    assert command("batch two.toml -o made")[0] == 0
    assert {path.name for path in Path("made").glob("*.nc")} == {"slow.nc", "fast.nc"}


def test_starts_that_are_no_grid(command):
    """Random starts and a table work, with one cell per start."""
    assert command("run mine.py hoop_rate=uniform:4:5 samples=200 seed=7 -o random.nc")[0] == 0
    assert_facts(command("info random.nc")[1], "200 starts")
    assert command("plot random.nc -o random.png")[0] == 0
    Path("table.csv").write_text("hoop_rate [rad/s],angle [deg]\n4.0,1.0\n5.0,1.0\n")
    assert command("run mine.py --starts table.csv -o table.nc")[0] == 0
    with sweep.open_atlas("table.nc") as atlas:
        assert list(atlas.stability.values) == [1, 2]


def test_a_criterion_of_ones_own():
    """It uses measures, parameters and endings, with units; changing it needs no integration."""
    text = "highest > 2*angle and lowest > -3deg"
    atlas = sweep.run(str(BEAD), **WORDS, criterion=text)
    unstable = (atlas.highest > 2.0 * atlas.angle) & (atlas.lowest > np.radians(-3.0))
    np.testing.assert_array_equal(atlas.stability == 2, unstable)
    assert 0 < int(unstable.sum()) < unstable.size
    again = atlas.eulerdisk.reclassify("highest > 3deg")
    np.testing.assert_array_equal(again.stability == 2, atlas.highest > np.radians(3.0))
    for wrong, facts in (("peak_tilt > 3deg", ["peak_tilt", "highest"]), ("highest > 3s", ["highest", "s"])):
        with refused(*facts):
            sweep.SweepSpec(model=str(BEAD), criterion=wrong)


def test_a_request_is_the_same_however_it_is_written(tmp_path):
    """Words, TOML, canonical text, pickle and repr give the same spec, which contains the system itself."""
    spec = sweep.SweepSpec.from_words("mine.py", GRID.split())
    (tmp_path / "hoop.toml").write_text(spec.to_toml())
    Path("mine.py").unlink()
    assert sweep.SweepSpec.from_toml(tmp_path / "hoop.toml") == spec
    assert sweep.SweepSpec.from_canonical(spec.canonical()) == spec
    assert pickle.loads(pickle.dumps(spec)) == spec
    assert spec.replace(angle="3deg").model is spec.model
    assert spec.fingerprint() != spec.replace(angle="3deg").fingerprint()


@pytest.mark.slow_lane
def test_a_preset_and_a_name_behind_a_colon(command):
    """`kapitza` is found by name, and one of several systems in a file is selected after a colon."""
    assert command("run kapitza angle=1deg shake=80:120:5 -o k.nc")[0] == 0
    Path("two.py").write_text(BEAD.read_text() + OTHER)
    status, _, told = command("plan two.py --no-calibrate")
    assert status == 2
    assert_facts(told, "mine.py:bead")
    assert command("run two.py:other -o o.nc")[0] == 0
    with sweep.open_atlas("o.nc") as atlas:
        assert float(atlas.x_end) == pytest.approx(np.exp(-1.0), abs=1e-14)


def test_a_cell_depends_on_itself_alone():
    """Threads and block size change no bit; each system has its own hash."""
    spec = sweep.SweepSpec.from_words(
        "mine.py", ["hoop_rate=3:6:23", "angle=0.1deg:60deg:37:log", "rate=0.3"]
    )
    whole = sweep.run(spec, threads=1)
    for cells in (7, 331):
        for name, column in sweep.run(spec, block_cells=cells).data_vars.items():
            assert column.values.tobytes() == whole[name].values.tobytes(), name
    assert arithmetic_hash(spec) != arithmetic_hash(sweep.SweepSpec.preset("rolling"))


def test_atlases_of_other_models_are_not_compared(made):
    """The message names the two models."""
    disk = sweep.run("rolling", roll_rate="2:3:3", tilt=0.01)
    with (
        sweep.open_atlas(made) as atlas,
        refused("bead and disk"),
    ):
        compare(atlas, disk)


def test_a_figure_in_python(made):
    """The accessor draws it; the refusal of friction gives no advice that only applies to the disk."""
    with sweep.open_atlas(made) as atlas:
        plots.save(plots.figure([atlas]), "a.png")
        with refused("bead") as caught:
            plots.figure([atlas], friction=0.3)
    assert "contact=yes" not in str(caught.value)


def process(words):
    """Start `eulerdisk` in a separate process."""
    return subprocess.Popen(
        [sys.executable, "-m", "sweep", *words.split()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
    )


@pytest.mark.slow_lane
def test_a_killed_run_goes_on():
    """After kill -9 halfway, the same command resumes and gives the bits of an undisturbed run."""
    words = "run mine.py hoop_rate=4:5:100 angle=0.01deg:4deg:50:log --block-cells 100 -o {}.nc"
    whole = process(words.format("whole"))
    whole.communicate()
    assert whole.returncode == 0
    killed = process(words.format("killed"))
    blocks = Path("killed.nc.run") / "blocks"
    while not (blocks.is_dir() and len(list(blocks.glob("*.block"))) >= 3):
        assert killed.poll() is None
        time.sleep(0.005)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert not Path("killed.nc").exists()
    again = process(words.format("killed"))
    _, messages = again.communicate()
    assert (again.returncode, bool(re.search(r"[1-9]\d* of 50 blocks", messages))) == (0, True), messages
    assert bits("killed.nc") == bits("whole.nc")


def test_a_motion_of_a_system(command, made):
    """`simulate` follows it from the atlas or the file, as Python does; its end matches the sweep's cell."""
    shutil.copy(made, "a.nc")
    words = "hoop_rate=4.4 angle=4deg duration=2s"
    for number, given in enumerate(("--from a.nc", "mine.py")):
        status, _, messages = command(f"simulate {given} {words} -o m{number}.nc")
        assert status == 0, messages
    cell = sweep.run("mine.py", hoop_rate=4.4, angle="4deg", duration="2s")
    with xr.open_dataset("m1.nc") as motion:
        assert float(motion.angle[-1]) == float(cell.angle_end)
        assert float(motion.elapsed_time[-1]) == float(cell.end_time)
    # The axis value of an atlas cell is rounded.
    with xr.open_dataset("m0.nc") as motion:
        assert float(motion.angle[-1]) == pytest.approx(float(cell.angle_end), rel=1e-9)


@pytest.mark.slow_lane
def test_the_explorer(command, made):
    """A page of the atlas, and one of the system, contain only the module of its own kernel."""
    shutil.copy(made, "a.nc")
    # Compiling must not import a module from the user's folder.
    Path("numba.py").write_text("raise SystemExit('not this one')\n", encoding="utf-8")
    for what in ("a.nc", "mine.py hoop_rate=3:6:50 angle=1deg:90deg:50"):
        status, _, messages = command(f"explore {what} --export page.html --overwrite")
        assert status == 0, messages
        page = Path("page.html").read_text(encoding="utf-8")
        packed = re.search(r'id="kernels">([^<]+)<', page)
        module = zlib.decompress(base64.b64decode(packed[1]))
        assert b'{"entries":{"integrate":' in module


def test_a_model_and_the_system_of_another_one():
    """A text that names one model but contains the system of another is refused."""
    text = sweep.SweepSpec.read("mine.py").canonical()
    assert sweep.SweepSpec.from_canonical(text).model.name == "bead"
    with refused("disk", "bead"):
        sweep.SweepSpec.from_canonical(text.replace('"model":"bead"', '"model":"disk"'))


@pytest.mark.slow_lane
def test_workers_of_dask_compute_it(made):
    """They get the system from the request, and give the same bits as this process."""
    distributed = pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        executor = dask_executor.on_cluster(cluster.scheduler_address)
        sweep.run_to_file("mine.py", "a.nc", executor=executor, block_cells=50, **WORDS)
    assert bits("a.nc") == bits(made)


def test_the_file_is_read_and_never_run(mine, tmp_path):
    """Code that only running the file would execute is refused with its line number."""
    text = mine.read_text()
    for line in ("import os", "open('touched', 'w')", "print(1)"):
        mine.write_text(text.replace("\n\n\n", f"\n{line}\n\n\n", 1))
        with pytest.raises(sweep.RequestError, match="line 2"):
            read_system_file(mine, "")
    assert not (tmp_path / "touched").exists()


def test_a_run_says_where_an_energy_is_none(command):
    """The largest change of such a quantity is reported with its cell; the file is complete."""
    text = '@system(duration="10", conserved="v**2 + x**2")\ndef odd(x=1.0, v=0.0, *, k=2.0):\n    return v, -k*x\n'
    Path("odd.py").write_text(f"from sweep.systems import system\n{text}")
    status, _, told = command("run odd.py k=0.9,1,2 -o odd.nc")
    assert status == 0
    assert_facts(told, "0.5", "k=2", "odd.nc")
    status, _, told = command("run odd.py k=1 -o even.nc")
    assert (status, "warning" in told) == (0, False)


def test_why_a_motion_could_not_be_followed_and_what_helps(command):
    """`run`, `explain` and `simulate` say why and until when; the ending that they suggest helps."""
    text = '@system(duration="10")\ndef blow_up(y=0.5):\n    return y**2\n'
    Path("up.py").write_text(f"from sweep.systems import system\n{text}")
    status, _, told = command("run up.py y=0.05,0.5 -o up.nc")
    assert status == 1
    assert_facts(told, "1 unresolved_growth", "y=0.5", 'ends={"escaped": "abs(y) > 1e6"}')
    status, told, _ = command("explain up.nc y=0.5")
    assert status == 0
    assert row(told, "  end_time").split()[1] == "2"
    status, _, told = command("simulate up.py y=0.5 -o path.nc")
    assert status == 2
    assert_facts(told, "2", 'ends={"escaped": "abs(y) > 1e6"}')
    Path("up.py").write_text(
        Path("up.py").read_text().replace('"10"', '"10", ends={"escaped": "abs(y) > 1e6"}')
    )
    assert command("run up.py y=0.05,0.5 -o escaped.nc")[0] == 0
    assert command("verify escaped.nc")[0] == 0
