"""Only one thread at a time calls netCDF, because two crash the process with a bus error within seconds."""

import threading

import netCDF4
import pytest
import xarray as xr
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

from sweep.files import one_thread
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs.run import Failures, run_to_file

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate="2:3:5")


def could_be_taken(lock):
    """Return True if another thread could get a lock now."""
    found = []

    def take():
        found.append(lock.acquire(blocking=False))
        if found[0]:
            lock.release()

    thread = threading.Thread(target=take)
    thread.start()
    thread.join()
    return found[0]


@pytest.fixture
def opened(monkeypatch):
    """Record, for each file that netCDF opens, which locks another thread could take meanwhile."""
    noted, real = [], netCDF4.Dataset

    class Noting(type):
        def __call__(cls, *arguments, **options):
            noted.append((could_be_taken(one_thread._OWN), could_be_taken(NETCDF4_PYTHON_LOCK)))
            return real(*arguments, **options)

        def __instancecheck__(cls, value):
            return isinstance(value, real)

    monkeypatch.setattr(netCDF4, "Dataset", Noting("Dataset", (), {}))
    return noted


def test_a_run_and_what_reads_its_file_call_netcdf_alone(tmp_path, opened):
    """While a run or a reader calls netCDF, neither another run nor xarray's cleanup in any thread does."""
    run_to_file(SPEC, tmp_path / "atlas.nc")
    Failures.in_file(tmp_path / "atlas.nc", SPEC)
    atlas = open_atlas(tmp_path / "atlas.nc")
    assert len(opened) == 6
    assert set(opened) == {(False, False)}
    save(atlas, tmp_path / "again.nc")
    assert opened[6:] == [(False, False)]
    atlas.close()


def test_progress_may_read_files(tmp_path):
    """A callback of a run may open files."""
    with xr.Dataset({"a": ("x", [1.0])}) as other:
        other.to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    run_to_file(SPEC, tmp_path / "first.nc")
    seen = []

    def read(status):
        with xr.open_dataset(tmp_path / "other.nc", engine="netcdf4") as file:
            seen.append(float(file["a"][0]))
        open_atlas(tmp_path / "first.nc").close()

    run_to_file(SPEC, tmp_path / "atlas.nc", progress=read)
    assert len(seen) > 2
