"""Checks give the same result block by block as for a whole atlas in memory."""

import numpy as np
import pytest

import sweep
from sweep.checks.compare import compare
from sweep.checks.verify import findings, findings_of, verify
from sweep.files import cell_reader
from sweep.files.cell_reader import CellReader
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

SPEC = SweepSpec.preset("circling").replace(
    tilt="2deg:25deg:16", precession_rate="0.2:5:17", boundary="refined:1e-3"
)


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas with two edges and curves; tests must not change it."""
    return sweep.run(SPEC)


def test_an_audit_is_written_and_its_findings_are_those_of_the_blocks(atlas, tmp_path):
    """Findings by blocks equal those of the whole audit, and the saved audit has the same content."""
    save(atlas, tmp_path / "a.nc")
    with open_atlas(tmp_path / "a.nc", indexed=False) as opened:
        expected, same = verify(opened), findings_of(opened)
    assert repr(findings(expected)) == repr(same)
    save(expected, tmp_path / "b.nc")
    with _opened(tmp_path / "b.nc") as stored:
        assert set(stored.variables) == set(expected.variables)
        for name, values in expected.variables.items():
            np.testing.assert_array_equal(stored[name].values, values.values, str(name))
            assert stored[name].dtype == values.dtype
            assert stored[name].attrs.keys() == values.attrs.keys()
        assert {k: str(v) for k, v in stored.attrs.items()} == {k: str(v) for k, v in expected.attrs.items()}


def _opened(path):
    import xarray as xr

    return xr.open_dataset(path, engine="netcdf4")


@pytest.mark.parametrize(
    ("values", "in_blocks"), [("2deg:25deg:31", True), ("2deg,10deg,20deg,25deg", False)]
)
def test_common_cells_are_read_in_blocks_where_they_are_evenly_spaced(
    atlas, tmp_path, monkeypatch, values, in_blocks
):
    """A grid with half the steps is read in blocks of both files; an unevenly spaced one is read as a whole."""
    axis = values if in_blocks else ",".join(repr(float(v)) for v in atlas["tilt"].values[[0, 3, 4, 9]])
    other = sweep.run(SPEC.replace(tilt=axis))
    save(atlas, tmp_path / "a.nc")
    save(other, tmp_path / "b.nc")
    asked, begin = [], CellReader.__init__

    def spied(self, dataset, names, whole=False):
        asked.append(whole)
        begin(self, dataset, names, whole)

    monkeypatch.setattr(CellReader, "__init__", spied)
    monkeypatch.setattr(cell_reader, "BLOCK_CELLS", 50)
    with open_atlas(tmp_path / "a.nc") as one, open_atlas(tmp_path / "b.nc") as two:
        in_files = compare(one, two, common=True)
    assert asked == [not in_blocks, False]
    assert in_files.same
    assert repr(in_files) == repr(compare(atlas, other, common=True))
