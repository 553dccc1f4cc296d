"""`eulerdisk verify` on the command line."""

import contextlib
import zlib

import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts

import sweep
from sweep.checks.verify import verify
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.model.disk.exact import AUDIT
from sweep.model.disk.tables import PARAMETERS
from sweep.model.quantity import FILL
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

pytestmark = pytest.mark.compiled

SPEC = SweepSpec.preset("rolling").replace(roll_rate="2:4:21", tilt="0.1deg:5deg:10:log")


@pytest.fixture(autouse=True)
def atlas(monkeypatch, tmp_path):
    """Put the atlas a.nc into the folder of every command."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    run_to_file(SPEC, tmp_path / "a.nc")


def rewritten(change, name="b.nc"):
    """Write a changed copy of a.nc."""
    with open_atlas("a.nc") as dataset:
        dataset.load()
    save(change(dataset), name)


def assign(name, value, place):
    """Return a function that changes one cell of a variable."""

    def change(dataset):
        dataset[name].values[place] = value
        return dataset

    return change


def test_a_right_atlas_passes(command, tmp_path):
    """A right atlas gives status 0 and a full report, and nothing is written."""
    before = (tmp_path / "a.nc").read_bytes()
    status, out, err = command("verify a.nc")
    assert (status, err) == (0, "")
    lines = out.splitlines()
    heads = ["cells", "tilts", "periods", "tolerance", "worst"]
    assert [line.split()[0] for line in lines[:5]] == heads
    assert_facts(lines[0], "210 agrees")
    assert_facts(lines[3], "1.0e-08 rad")
    assert_facts(lines[4], "roll_rate", "rad s-1", "tilt", "deg")
    assert_facts(lines[-1], "verified: 210 of 210 cells", "1e-08 rad")
    table = [line.split()[0] for line in lines[lines.index("") + 1 : lines.index("", lines.index("") + 1)]]
    with open_atlas("a.nc") as dataset:
        assert [name for name in table if name in dataset] == [*dataset.coords, *dataset.data_vars]
    assert " wrong" not in out
    assert list(tmp_path.iterdir()) == [tmp_path / "a.nc"]
    assert (tmp_path / "a.nc").read_bytes() == before


def test_a_wrong_cell_fails_and_is_named(command):
    """A wrong cell gives status 1 and is named by its coordinates and its fault."""
    rewritten(assign("tilt_max", 0.5, (3, 4)))
    status, out, err = command("verify b.nc")
    assert (status, err) == (1, "")
    tilt = np.degrees(SPEC.tilt.array()[4])
    assert_facts(out, "209 agrees", "1 extremes differ")
    (wrong,) = (line for line in out.splitlines() if line.startswith("wrong "))
    assert_facts(wrong, "roll_rate 2.3 rad s-1", f"tilt {tilt:.10g} deg", "extremes differ")
    assert_facts(out.splitlines()[-1], "NOT verified", "1 of 210 cells", "0", "wrong: tilt_max")


def test_a_part_fails(command):
    """An atlas whose cells are partly not computed yet does not pass."""
    rewritten(assign("ending", 0, (slice(2), slice(None))))
    status, out, _ = command("verify b.nc")
    assert status == 1
    assert_facts(out, "20 not computed", "190 agrees")
    assert_facts(out.splitlines()[-1], "NOT verified", "0 of 210 cells", "20")


@pytest.mark.parametrize(
    "words", ["tilt=1deg roll_rate=3", "tilt=1deg roll_rate=2:4:5 alpha=0.5,1 gravity=1,9.81"]
)
def test_any_number_of_axes(command, words):
    """Atlases of one cell and of three axes are verified like a map, and their audits are written."""
    assert command(f"run rolling {words} -o b.nc")[0] == 0
    status, out, _ = command("verify b.nc --write c.nc")
    assert status == 0
    if "alpha" not in words:
        (worst,) = (line for line in out.splitlines() if line.startswith("worst cell "))
        assert_facts(worst, "agrees")
    with xr.open_dataset("c.nc") as written:
        assert written.audit.size in (1, 20)


def cut(path):
    """Truncate a file."""
    path.write_bytes(path.read_bytes()[:-100])


def blot(path):
    """Damage the compressed values of the measures, but nothing that is read on opening."""
    data = bytearray(path.read_bytes())
    for i in range(len(data) - 1):
        # the start of a deflate stream of any level
        if data[i] == 0x78 and int.from_bytes(data[i : i + 2]) % 31 == 0:
            with contextlib.suppress(zlib.error):
                if len(zlib.decompressobj().decompress(data[i:])) == 8 * SPEC.size:
                    data[i : i + 8] = b"\xff" * 8
    assert data != path.read_bytes()
    path.write_bytes(data)


def foreign(path):
    """Replace a file by an unrelated netCDF file."""
    xr.Dataset({"temperature": ("x", [1.0])}, attrs={"title": "Ocean"}).to_netcdf(path)


@pytest.mark.parametrize(
    ("spoil", "facts"),
    [
        (cut, ["netCDF-4", "bytes"]),
        (blot, ["tilt_min", "HDF error"]),
        (foreign, ["stability atlas", "Ocean"]),
        (lambda path: path.unlink(), ["no such file"]),
        (lambda path: path.write_text("roll_rate"), ["netCDF-4", "9 bytes"]),
    ],
)
def test_a_file_that_is_no_whole_atlas_is_refused(command, tmp_path, spoil, facts):
    """A damaged or unrelated file gives status 2 and one message, and --write writes nothing."""
    (tmp_path / "b.nc").write_bytes((tmp_path / "a.nc").read_bytes())
    spoil(tmp_path / "b.nc")
    status, out, err = command("verify b.nc --write c.nc")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert_facts(err, "b.nc:", *facts)
    assert not (tmp_path / "c.nc").exists()


@pytest.mark.parametrize(
    "names", [["nutation_period"], ["stability"], ["peak_tilt", "amplification"], ["tilt_min"]]
)
def test_missing_variables_are_named(command, names):
    """An atlas without variables that the audit needs is refused, and only these are named."""
    with open_atlas("a.nc") as dataset:
        # written as by another program, because our own save refuses such an atlas
        dataset.drop_vars(names).to_netcdf("b.nc")
    status, out, err = command("verify b.nc")
    assert (status, out) == (2, "")
    assert_facts(err, ", ".join(names))
    assert "ending" not in err


def test_an_audit_is_no_atlas(command):
    """An audit file cannot be verified, and the message says why."""
    assert command("verify a.nc --write b.nc")[0] == 0
    status, _, err = command("verify b.nc")
    assert status == 2
    assert_facts(err, "b.nc:", "ending, stability")


def test_what_is_written(command, tmp_path):
    """The written audit equals the Python result, has flags and the profile of atlases, even if cells disagree."""
    rewritten(assign("tilt_max", 0.5, (3, 4)))
    assert command("verify b.nc --write c.nc")[0] == 1
    with xr.open_dataset("c.nc") as written, open_atlas("b.nc") as dataset:
        xr.testing.assert_identical(written, verify(dataset))
        assert_facts(written.attrs["title"], "Audit", dataset.attrs["title"])
        assert written.attrs["history"].endswith("\n1970-01-01T00:00:00Z sweep.verify")
        assert int((written.audit == 7).sum()) == 1
    with netCDF4.Dataset("c.nc") as file:
        assert file.data_model == "NETCDF4_CLASSIC"
        assert file["audit"].flag_meanings.split()[:2] == ["not_computed", "agrees"]
        assert len(file["audit"].flag_meanings.split()) == file["audit"].flag_values.size == 13
        for name, variable in file.variables.items():
            measured = name in AUDIT.variables and variable.dtype.kind == "f"
            assert variable.dtype.str in ("|i1", "<f8"), name
            assert getattr(variable, "_FillValue", None) == (FILL if measured else None), name
            assert name in AUDIT.variables or name in PARAMETERS
            if name in AUDIT.variables:
                assert variable.filters()["zlib"]
            for attribute in variable.ncattrs():
                text = variable.getncattr(attribute)
                assert not isinstance(text, str) or text.isascii()


def test_an_existing_file_is_kept(command, tmp_path):
    """An audit replaces a file only with --overwrite, and never its own atlas."""
    (tmp_path / "b.nc").write_text("old")
    before = (tmp_path / "a.nc").read_bytes()
    (tmp_path / "reference.nc").write_bytes(before)
    for line, facts in (
        ("compare a.nc reference.nc --junit a.nc", ["a.nc", "replace"]),
        ("compare a.nc reference.nc --junit reference.nc", ["reference.nc", "replace"]),
        ("verify a.nc --write b.nc", ["b.nc", "--overwrite"]),
        ("verify a.nc --write a.nc --overwrite", ["a.nc", "replace"]),
        ("verify a.nc --write ./a.nc", ["a.nc", "replace"]),
        ("verify a.nc --write no/b.nc", ["no/b.nc", "mkdir -p no"]),
    ):
        status, out, err = command(line)
        assert (status, out) == (2, "")
        assert_facts(err, *facts)
        assert (tmp_path / "b.nc").read_text() == "old"
        assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "reference.nc").read_bytes() == before
    assert command("verify a.nc --write b.nc --overwrite")[0] == 0
    with xr.open_dataset("b.nc") as written:
        assert "audit" in written


@pytest.mark.slow_lane
def test_the_exact_method_from_the_command_line(command):
    """`method=exact` makes an atlas that states its method, is read by every command, and passes."""
    assert command("run rolling method=exact roll_rate=2:4:21 tilt=0.1deg:5deg:10:log -o b.nc")[0] == 0
    assert "method      exact" in command("info b.nc")[1]
    status, out, _ = command("verify b.nc")
    assert status == 0
    assert_facts(out.splitlines()[-1], "reduction", "sample", "in space")
    assert "in space" not in command("verify a.nc")[1]
    assert command("boundary b.nc")[1] == command("boundary a.nc")[1]
    assert command("plot b.nc -o b.png")[0] == 0
    with sweep.open_atlas("b.nc") as dataset:
        assert dataset.attrs["method"] == "exact"
