"""A second model proves the seam: the bead on a turning hoop goes through every room, and none of them knows of it.

Its referees are closed forms: the Jacobi integral angle'^2/2 - hoop_rate^2 sin(angle)^2/2 - (g/R) cos(angle) for the
turning points, the frequency sqrt(g/R - hoop_rate^2) of small oscillations, the critical rate sqrt(g/R).
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from scipy.optimize import brentq

import sweep
from sweep.checks.compare import compare
from sweep.engine.compute import arithmetic_hash, compute
from sweep.errors import RequestError
from sweep.figures import plots
from sweep.model import registry
from sweep.motion.origin import cell_and_changes

HERE = Path(__file__).parent
CHECKOUT = HERE.parents[1]
CRITICAL = np.sqrt(9.81 / 0.5)


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """Let the bead be installed: a package, and the metadata that register its model."""
    monkeypatch.syspath_prepend(str(HERE))
    for each in (registry.named, registry._registered):
        each.cache_clear()
    yield
    for each in (registry.named, registry._registered):
        each.cache_clear()


def process(words, folder, **more):
    """Start `eulerdisk` in a process of its own that finds the bead, too."""
    environment = {
        **os.environ,
        "PYTHONPATH": f"{CHECKOUT}{os.pathsep}{HERE}",
        "SOURCE_DATE_EPOCH": "1700000000",
    }
    return subprocess.Popen(
        [sys.executable, "-m", "sweep", *words.split()],
        cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more,
    )  # fmt: skip


def finished(words, folder):
    """Run a command line to its end, and return its status, output and messages."""
    command = process(words, folder)
    output, messages = command.communicate()
    return command.returncode, output, messages


def turning_points(angle, angle_rate, hoop_rate, radius, gravity):
    """Return the two angles around a start at which the Jacobi integral leaves no kinetic energy, by bisection."""
    hoop, pull = hoop_rate**2, gravity / radius

    def kinetic(x):
        rise = 0.5 * hoop * (np.sin(x) ** 2 - np.sin(angle) ** 2) + pull * (np.cos(x) - np.cos(angle))
        return 0.5 * angle_rate**2 + rise

    found = []
    for side in (-1.0, 1.0):
        steps = angle + side * np.linspace(1e-9, 4.0, 40001)
        beyond = int(np.argmax(kinetic(steps) < 0.0))
        found.append(brentq(kinetic, steps[beyond - 1], steps[beyond], xtol=1e-14))
    return found


def test_the_model_is_found_by_its_name():
    """The bead is registered by an entry point; it differs from the disk in the numbers of its rows."""
    bead, disk = registry.named("bead"), registry.named("disk")
    assert "bead" in registry.names()
    for rows in ("parameters", "settings", "measures", "counts"):
        assert len(getattr(bead, rows)) != len(getattr(disk, rows))


def test_no_line_of_the_engine_knows_of_it():
    """Neither `sweep` nor `kernels` mentions a bead, a hoop rate or any other name of the model."""
    for path in (*CHECKOUT.glob("sweep/**/*.py"), *CHECKOUT.glob("kernels/**/*.py")):
        text = path.read_text(encoding="utf-8").lower()
        assert not [name for name in ("bead", "hoop_rate", "angle_min", "angle_rate") if name in text], path


def test_the_model_is_small():
    """The whole model takes at most 200 lines."""
    assert sum(len(path.read_text().splitlines()) for path in (HERE / "bead").glob("*.py")) <= 200


def test_turning_points_and_periods(rng):
    """Random starts turn where the Jacobi integral says, and small ones swing with sqrt(g/R - hoop_rate^2)."""
    n = 60
    starts = {
        "angle": rng.uniform(-1.2, 1.2, n),
        "angle_rate": rng.uniform(-1.0, 1.0, n),
        "hoop_rate": rng.uniform(0.0, 8.0, n),
        "radius": 10.0 ** rng.uniform(-1.0, 0.5, n),
        "gravity": 10.0 ** rng.uniform(0.0, 1.2, n),
    }
    found = compute(sweep.SweepSpec(model="bead"), starts)
    assert (found["ending"] == 1).mean() > 0.9
    for i in np.flatnonzero(found["ending"] == 1):
        start = {name: float(values[i]) for name, values in starts.items()}
        expected = turning_points(**start)
        ends = [found["angle_min"][i], found["angle_max"][i]]
        np.testing.assert_allclose(ends, expected, rtol=0.0, atol=1e-8, err_msg=str(start))
    for hoop in (0.0, 2.0, 4.0):
        cell = sweep.run(sweep.SweepSpec(model="bead", angle=1e-5, hoop_rate=hoop))
        assert float(cell.period) == pytest.approx(2.0 * np.pi / np.sqrt(CRITICAL**2 - hoop**2), rel=1e-8)


def test_an_error_is_estimated_where_the_bead_turned(command):
    """A cell whose time was over first has no estimate; `info` reports the largest one of the cells that turned."""
    words = "hoop_rate=0:9:7 angle=-170deg:170deg:9 duration=2s"
    cells = sweep.run(sweep.SweepSpec.from_words("bottom", words.split()))
    ending, error = cells.ending.values, cells.angle_error.values
    assert set(ending.flat) == {1, 2}
    np.testing.assert_array_equal(np.isnan(error), ending == 2)
    assert np.all(error[ending == 1] <= 1e-6)
    assert command(f"run bottom {words} -o a.nc")[0] == 0
    assert f"extreme angles within {np.nanmax(error):.1e} rad" in command("info a.nc")[1]


def test_bits_depend_on_the_cell_alone():
    """Threads and block size change no bit, for a model with other rows than the disk's."""
    spec = sweep.SweepSpec.preset("bottom").replace(
        hoop_rate="3:6:23", angle="0.1deg:60deg:37:log", angle_rate=0.3
    )
    whole = sweep.run(spec, threads=1)
    for cells in (7, 331):
        for name, column in sweep.run(spec, block_cells=cells).data_vars.items():
            assert column.values.tobytes() == whole[name].values.tobytes(), name


def test_the_boundary_is_a_lower_edge():
    """The measured edge holds the predicted one, and comes down to sqrt(g/R) as criterion and start shrink."""
    errors = []
    for degrees in (8.0, 4.0, 2.0):
        spec = sweep.SweepSpec.preset("bottom").replace(
            hoop_rate="4:5:51", angle=[1e-4], criterion=f"departure:{degrees}deg", boundary="refined:1e-9"
        )
        edge = sweep.run(spec).eulerdisk.boundary("hoop_rate", "lower")
        assert float(edge.critical[0]) == pytest.approx(CRITICAL, rel=1e-15)
        assert abs(float(edge.measured[0] - edge.predicted[0])) <= 1e-7
        errors.append(float(edge.measured[0]) - CRITICAL)
    # the edge is a power series in the square of the angle
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.01)


def test_words_toml_and_text_make_the_same_request(tmp_path):
    """Words, a TOML file, Python and the canonical text of a file name the same spec."""
    spec = sweep.SweepSpec.from_words("bottom", ["hoop_rate=4:5:5", "angle=1deg,2deg"])
    (tmp_path / "hoop.toml").write_text(spec.to_toml())
    assert sweep.SweepSpec.from_toml(tmp_path / "hoop.toml") == spec
    assert sweep.SweepSpec.from_canonical(spec.canonical()) == spec
    assert json.loads(spec.canonical())["model"] == "bead"
    assert spec.replace(angle="3deg").model.name == "bead"


def test_what_the_model_has_not_is_refused():
    """Another model's words, a method that it lacks, a value against its rules: refused by name."""
    for words, told in [
        ({"model": "os"}, "no model 'os'"),
        ({"model": "bead", "roll_rate": 3.0}, "roll_rate"),
        ({"model": "bead", "method": "exact"}, "method is rk4"),
        ({"model": "bead", "radius": -1.0}, "radius > 0"),
        ({"model": "bead", "criterion": "aloft:10s"}, "states of no motion when it is lost"),
        ({"hoop_rate": 3.0}, "hoop_rate"),
    ]:
        with pytest.raises(sweep.RequestError, match=told):
            sweep.SweepSpec(**words)


def test_a_file_names_a_model_and_imports_nothing(tmp_path):
    """An atlas whose model is not registered is refused, whatever module bears the name."""
    (tmp_path / "antigravity_model.py").write_text("raise SystemExit('imported')")
    spec = sweep.SweepSpec.preset("bottom")
    text = spec.canonical().replace('"bead"', '"antigravity_model"')
    with pytest.raises(sweep.RequestError, match="antigravity_model"):
        sweep.SweepSpec.from_canonical(text)


def test_every_command(command, tmp_path):
    """Run, info, boundary, plot, explain, compare and export work; verify and regimes are refused by name."""
    path, again = tmp_path / "a.nc", tmp_path / "b.nc"
    assert command("run bottom hoop_rate=4:5:21 angle=0.1deg:4deg:7:log -o a.nc")[0] == 0
    with sweep.open_atlas(path) as atlas:
        assert list(atlas.sizes.items()) == [("hoop_rate", 21), ("angle", 7)]
        assert atlas.attrs["title"] == "Bead on a turning hoop: stability of the bottom"
        assert set(atlas.stability.values.flat) == {1, 2}
        plots.save(plots.figure([atlas]), tmp_path / "a.png")
    for words, told in (
        ("info a.nc", "stable below hoop_rate"),
        ("boundary a.nc", "predicted_lower_hoop_rate"),
        ("explain a.nc hoop_rate=4.4 angle=1deg", "every value agrees bit for bit"),
        ("run --from a.nc -o b.nc", ""),
        ("compare b.nc a.nc", "identical: 147 cells"),
        ("export a.nc --to csv", ""),
        ("explore a.nc --export a.html", ""),
        ("plan bottom --no-calibrate", "4040"),
    ):
        status, output, messages = command(words)
        assert (status, told in output) == (0, True), (words, output, messages)
    assert path.read_bytes()[:4] == again.read_bytes()[:4]
    # a page without motions opens with none
    held = json.loads(
        re.search(r'id="stored">(.*?)</script>', (tmp_path / "a.html").read_text(), re.DOTALL)[1]
    )
    assert (held["motions"], held["about"]["bases"][0]["moves"]) == (None, False)
    for words, told in (
        ("verify a.nc", "bead has no exact reference"),
        ("plot --regimes a.nc -o r.png", "bead has no regimes"),
        ("plot --friction 0.3 a.nc -o r.png", "no contact forces"),
        ("explain a.nc hoop_rate=4.4 angle=1deg --plot r.png", "bead has no trajectory"),
    ):
        status, _, messages = command(words)
        assert (status, told in messages) == (2, True), (words, messages)


def test_other_atlases_are_not_comparable(tmp_path):
    """An atlas of the bead and one of the disk are of different models."""
    bead = sweep.run(sweep.SweepSpec.preset("bottom").replace(hoop_rate="4:5:3", angle=0.01))
    disk = sweep.run(sweep.SweepSpec.preset("rolling").replace(roll_rate="2:3:3", tilt=0.01))
    with pytest.raises(sweep.RequestError, match="different models: bead and disk"):
        compare(bead, disk)


def test_a_killed_run_goes_on(tmp_path):
    """After kill -9 in the middle the same command goes on, to the bytes of an undisturbed run."""
    words = "run bottom hoop_rate=4:5:200 angle=0.01deg:4deg:50:log --block-cells 100 -o {}.nc"
    assert finished(words.format("whole"), tmp_path)[0] == 0
    killed = process(words.format("killed"), tmp_path)
    blocks = tmp_path / "killed.nc.run" / "blocks"
    while not (blocks.is_dir() and len(list(blocks.glob("*.block"))) >= 3):
        assert killed.poll() is None
        time.sleep(0.005)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert not (tmp_path / "killed.nc").exists()
    status, _, messages = finished(words.format("killed"), tmp_path)
    assert status == 0
    assert "going on" in messages
    with netCDF4.Dataset(tmp_path / "whole.nc") as whole, netCDF4.Dataset(tmp_path / "killed.nc") as again:
        for each in (whole, again):
            each.set_auto_maskandscale(False)
        for name in whole.variables:
            assert whole[name][...].tobytes() == again[name][...].tobytes(), name


def test_the_hash_of_the_code_is_that_of_the_model():
    """Its kernels are compiled under a key of their own: the schedule's, and not the disk's."""
    bead, disk = (sweep.SweepSpec.preset(name) for name in ("bottom", "rolling"))
    assert arithmetic_hash(bead) != arithmetic_hash(disk)


def test_docs_walk_through_this_model():
    """What docs/own-model.md quotes of the model stands in it."""
    page = (CHECKOUT / "docs" / "own-model.md").read_text(encoding="utf-8")
    code = [path.read_text(encoding="utf-8") for path in sorted((HERE / "bead").glob("*.py"))]
    quoted = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(quoted) > 4
    assert [quote for quote in quoted if not any(quote in each for each in code)] == []


def test_friction_is_refused_by_name():
    """A model without contact forces says so, and gives no advice that only the disk can follow."""
    atlas = sweep.run(sweep.SweepSpec.preset("bottom").replace(hoop_rate="4:5:5", angle="1deg,2deg"))
    with pytest.raises(sweep.RequestError, match="model bead has no contact forces") as caught:
        plots.figure([atlas], friction=0.3)
    assert "contact=yes" not in str(caught.value)


def test_its_own_variables_make_a_criterion():
    """An expression names the variables and the parameters of the model, and nothing of another one."""
    text = "peak_angle > 2*angle and period > 1.5s"
    atlas = sweep.run(sweep.SweepSpec(model="bead", hoop_rate="3:5:21", angle="1deg,3deg", criterion=text))
    assert atlas.attrs["criterion"] == text
    unstable = (atlas.peak_angle > 2.0 * atlas.angle) & (atlas.period > 1.5)
    np.testing.assert_array_equal(atlas.stability == 2, unstable)
    assert 0 < int(unstable.sum()) < unstable.size
    assert atlas.predicted_lower_hoop_rate.isnull().all()
    assert np.allclose(atlas.critical_lower_hoop_rate, CRITICAL)
    with pytest.raises(sweep.RequestError, match="peak_tilt names nothing"):
        sweep.SweepSpec(model="bead", criterion="peak_tilt > 3deg")
    with pytest.raises(sweep.RequestError, match="peak_tilt names nothing"):
        sweep.SweepSpec(model="bead", criterion=sweep.Criterion.parse("peak_tilt > 3deg"))


def test_a_bead_has_no_motion_of_a_disk():
    """It does not roll: `simulate --from` names the models."""
    with pytest.raises(
        RequestError, match="one of the model disk or lossy_disk; got an atlas of the model bead"
    ):
        cell_and_changes(sweep.SweepSpec(model="bead"), {"hoop_rate": 1.0})
