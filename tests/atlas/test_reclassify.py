import importlib.util

import numpy as np
import pytest
import xarray as xr
from messages import refused

import sweep
from sweep.errors import RequestError
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.model.disk.tables import VARIABLES
from sweep.model.quantity import STABLE, UNSTABLE
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

SPECS = {
    "rolling": SweepSpec.preset("rolling").replace(roll_rate="2:4:30", tilt="0.1deg:4deg:6:log"),
    "circling": SweepSpec.preset("circling").replace(tilt="5deg:25deg:5", precession_rate="0:5:30"),
    "falling": SweepSpec(roll_rate="-3:3:9", tilt="20deg"),
    # only its own criterion gives the band a lower edge
    "band": SweepSpec(tilt="1deg", roll_rate=2, precession_rate="0:6:61", criterion="amplification:1000"),
    "cell": SweepSpec(tilt="1deg", roll_rate=3),
}
CRITERIA = ["departure:2deg", "departure:30deg", "amplification:3", "amplification:1000"]


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all atlases of one spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")


def test_it_is_as_if_run_with_that_criterion():
    """Verdicts, boundaries and attributes are bit for bit those of a new run; only the request differs."""
    for spec in SPECS.values():
        for criterion in CRITERIA:
            changed = sweep.reclassify(sweep.run(spec), criterion)
            fresh = sweep.run(spec.replace(criterion=criterion))
            assert changed.attrs.pop("history") == (
                f"1970-01-01T00:00:00Z sweep.run\n1970-01-01T00:00:00Z reclassified with {criterion}"
            )
            del fresh.attrs["history"], changed.attrs["requested_as"], fresh.attrs["requested_as"]
            xr.testing.assert_identical(changed, fresh)
            for name, variable in fresh.variables.items():
                assert changed[name].encoding == variable.encoding, name


def test_the_criteria_differ_in_their_verdicts():
    """These criteria give different verdicts, so that equality after reclassifying means something."""
    atlas = sweep.run(SPECS["rolling"])
    verdicts = {sweep.reclassify(atlas, each).stability.values.tobytes() for each in CRITERIA}
    assert len({*verdicts, atlas.stability.values.tobytes()}) == len(CRITERIA) + 1


def test_measures_are_kept_and_the_atlas_is_not_changed():
    """The measures are the same, and the input atlas keeps its own verdicts."""
    atlas = sweep.run(SPECS["rolling"])
    before = atlas.copy(deep=True)
    changed = sweep.reclassify(atlas, "departure:1deg")
    xr.testing.assert_identical(atlas, before)
    assert not np.array_equal(changed.stability, atlas.stability)
    for name in set(VARIABLES) - {"stability"}:
        xr.testing.assert_identical(changed[name], atlas[name])


def test_nothing_is_integrated(monkeypatch):
    """Reclassifying needs no kernel: finished measures are enough."""
    atlas = sweep.run(SPECS["rolling"])
    monkeypatch.setattr("sweep.engine.compute.measure", None)
    sweep.reclassify(atlas, sweep.Criterion.parse("departure:2deg"))


def test_a_file_can_be_reclassified_and_saved(tmp_path):
    """An atlas that is read, reclassified and saved reads back as it was saved."""
    run_to_file(SPECS["circling"], tmp_path / "a.nc")
    with open_atlas(tmp_path / "a.nc") as atlas:
        changed = sweep.reclassify(atlas, "departure:1deg").load()
    save(changed, tmp_path / "b.nc")
    with open_atlas(tmp_path / "b.nc") as read:
        xr.testing.assert_identical(read, changed)


def test_no_criterion_is_refused():
    """Text that is not a criterion is refused as in a request."""
    for criterion in ["departure", "departure:0deg", "amplitude:3", ""]:
        with pytest.raises(RequestError) as caught:
            sweep.reclassify(sweep.run(SPECS["cell"]), criterion)
        assert str(caught.value.where).partition("=")[0] == "criterion"


def test_public_names_are_not_modules():
    """No public name of the package is also a module, because importing the module would replace it."""
    for name in sweep.__all__:
        assert importlib.util.find_spec(f"sweep.{name}") is None, name


def test_a_criterion_that_judges_by_other_variables(monkeypatch):
    """A criterion that uses a time and no extremes can reclassify a finished atlas, too."""
    atlas = sweep.run(SPECS["falling"].replace(tilt_rate=1.0, precession_rate="0:2:5"))
    middle = float(atlas.fall_time.median())

    def verdict(self, endings, measured, reach, scale):
        return np.where(measured["fall_time"] < middle, UNSTABLE, STABLE).astype(np.int8)

    monkeypatch.setattr(Criterion, "needs", lambda self, model: ("ending", "fall_time"))
    monkeypatch.setattr(Criterion, "verdict", verdict)
    found = sweep.reclassify(atlas, "departure:2deg").stability
    assert ((found == UNSTABLE) == (atlas.fall_time < middle)).all()
    assert 0 < (found == UNSTABLE).sum() < found.size


def test_refining_on_a_device_that_is_not_here_is_refused(monkeypatch):
    """An atlas made on a device that this machine lacks can be read, but not refined."""
    monkeypatch.setattr("sweep.engine.compute.problem_of_cuda", lambda: "there is none")
    atlas = sweep.run(SPECS["rolling"])
    made = SPECS["rolling"].replace(device="cuda")
    elsewhere = atlas.assign_attrs(sweep_spec=made.canonical(), sweep_fingerprint=made.fingerprint())
    with refused("CUDA"):
        sweep.refine(elsewhere, 1e-3)
