"""Unfinished runs: their finished blocks are readable, for every method and option."""

import numpy as np
import pytest
from messages import refused

from sweep.engine.compute import compute, measure_block
from sweep.engine.grid import starts_of
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, manifest
from sweep.runs.partial import describe, write_partial

SPEC = SweepSpec(roll_rate="2:4:6", tilt="0.1deg,1deg")
SPECS = {
    "rk4": SPEC,
    "exact": SPEC.replace(method="exact"),
    "contact": SPEC.replace(contact="yes"),
    "circling": SweepSpec(tilt="1deg:20deg:3", precession_rate="2,3,4,5", roll_rate="steady"),
    "steady-slow": SweepSpec(tilt="1deg:20deg:3", roll_rate="-9:-5:4", precession_rate="steady-slow"),
}


@pytest.fixture
def begun(tmp_path, request):
    """Return the journal of a run in which only the second of four blocks is stored."""
    journal = array_jobs.prepare(request.param, tmp_path / "a.nc", block_cells=3)
    journal.keep(1, measure_block(journal.spec, journal.spans[1]))
    return journal


@pytest.mark.parametrize("begun", SPECS.values(), ids=SPECS, indirect=True)
def test_what_there_is_can_be_read(begun, tmp_path):
    """Every variable is present, for every method; cells of missing blocks have no numbers."""
    spec, path = begun.manifest.spec, tmp_path / "p.nc"
    assert write_partial(begun.folder, path) == (3, 12)
    columns = compute(spec, starts_of(spec, begun.spans[1]))
    with open_atlas(path) as part:
        assert set(columns) <= set(part.data_vars)
        for name, column in columns.items():
            found = part[name].values.ravel()
            np.testing.assert_array_equal(found[3:6], column)
            others = np.delete(found, slice(3, 6))
            assert (np.isnan(others) if found.dtype.kind == "f" else others == 0).all()


@pytest.mark.parametrize("begun", [SPEC], indirect=True)
def test_a_block_with_two_results_is_not_there(begun, tmp_path):
    """If two machines disagree, neither result is shown."""
    columns = dict(measure_block(SPEC, begun.spans[1]))
    columns["tilt_max"] = np.nextafter(columns["tilt_max"], 9)
    begun.keep(1, columns)
    assert write_partial(begun.folder, tmp_path / "p.nc") == (0, 12)


@pytest.mark.parametrize("begun", [SPEC], indirect=True)
def test_blocks_of_another_program_are_not_passed_off_as_its_own(begun, tmp_path, monkeypatch):
    """An atlas names its kernels, so blocks of other kernels are refused; the progress can still be shown."""
    monkeypatch.setattr(manifest, "arithmetic_hash", lambda _: "0" * 64)
    with refused("arithmetic_hash"):
        write_partial(begun.folder, tmp_path / "p.nc")
    assert "blocks      1 of 4" in describe(begun.folder)
    assert not (tmp_path / "p.nc").exists()
