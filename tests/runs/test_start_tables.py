"""Runs of starts from a table: the values lie in the folder of the run and in the file, and have their SHA-256."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest

import sweep
from sweep.errors import RequestError
from sweep.runs import array_jobs
from sweep.runs.folder import STARTS
from sweep.runs.journal import Journal
from sweep.runs.partial import write_partial
from sweep.runs.run import run_to_file

RANDOM = np.random.default_rng(5)
COLUMNS = {"roll_rate": RANDOM.uniform(2.0, 4.0, 600), "tilt": RANDOM.normal(0.02, 0.005, 600)}
SPEC = sweep.SweepSpec.preset("rolling").replace(starts=COLUMNS)


RANDOM_SPEC = sweep.SweepSpec(roll_rate=3.0, tilt="uniform:0:1deg", samples=600)


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Files of one spec bear one date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Return the bytes of the file of an undisturbed run."""
    path = tmp_path_factory.mktemp("reference") / "a.nc"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1700000000")
        run_to_file(SPEC, path)
    return path.read_bytes()


def test_commands(command):
    """From a CSV file to the atlas, and from the atlas alone to the same atlas."""
    rows = "\n".join(
        f"{rate!r},{tilt!r}" for rate, tilt in zip(*(each.tolist() for each in COLUMNS.values()), strict=True)
    )
    Path("pushes.csv").write_text(f"roll_rate [rad/s],tilt [rad]\n{rows}\n")
    assert command("run rolling --starts pushes.csv -o a.nc")[0] == 0
    Path("pushes.csv").unlink()
    status, text, _ = command("info a.nc")
    assert status == 0
    assert f"starts      600 of a table, SHA-256 {SPEC.starts.sha256[:16]}" in text
    assert f"  roll_rate         from a table, {COLUMNS['roll_rate'].min():.6g} rad s-1 to" in text
    assert "of 600 starts with a verdict; 95 % interval" in text
    assert command("verify a.nc")[0] == 0
    assert command("explain a.nc start=599")[0] == 0
    assert command("plot a.nc -o a.png")[0] == 0
    assert command("run --from a.nc -o b.nc")[0] == 0
    status, text, _ = command("compare b.nc a.nc")
    assert (status, text.splitlines()[0]) == (0, "identical: 600 cells, all 20 variables bit for bit")
    with sweep.open_atlas("a.nc") as atlas:
        assert atlas.eulerdisk.spec == SPEC
        assert np.array_equal(atlas.tilt, COLUMNS["tilt"])
        assert atlas.attrs["history"].endswith("eulerdisk run rolling starts=pushes.csv -o a.nc")
        assert "values" not in atlas.attrs["sweep_spec"]
        judged = sweep.reclassify(atlas.load(), "departure:20deg")
        assert judged.eulerdisk.spec == SPEC.replace(criterion="departure:20deg")
    assert command("run --from a.nc start=0:9 -o few.nc")[0] == 0
    assert "starts      10 of a table" in command("info few.nc")[1]


def test_a_missing_table_touches_nothing(command):
    """It is refused before anything is written."""
    for line in ("run", "prepare", "plan"):
        status, _, errors = command(f"{line} rolling --starts no.csv -o a.nc")
        assert status == 2
        assert "no.csv: The table of starts cannot be read" in errors
    assert not list(Path().iterdir())


def test_tables_that_differ_are_not_compared(command):
    """Cells are aligned by their number, and the starts must be equal."""
    for name, rate in (("a", 3.0), ("b", 3.0000001)):
        Path(f"{name}.csv").write_text(f"tilt [deg],roll_rate\n1,2\n1,{rate}\n")
        assert command(f"run rolling --starts {name}.csv -o {name}.nc")[0] == 0
    assert "they differ in starts" in command("compare a.nc b.nc")[2]


def test_parts_of_a_table_are_compared(command):
    """With --common, in the starts that both have, whose values have to be the same."""
    atlas = sweep.run(SPEC.replace(start="0:4:5"))
    for name, places in (("a", slice(0, 3)), ("b", slice(1, 5)), ("c", slice(4, 5))):
        sweep.save(atlas.isel(start=places).eulerdisk.atlas, f"{name}.nc")
    assert "on the same grid" in command("compare b.nc a.nc")[2]
    status, text, _ = command("compare b.nc a.nc --common")
    assert (status, text.splitlines()[0]) == (0, "within tolerance: 2 common cells")
    assert "no cell in common" in command("compare c.nc a.nc --common")[2]
    # start 1 is another one
    columns = {name: np.where(np.arange(600) == 1, values + 1e-7, values) for name, values in COLUMNS.items()}
    sweep.save(sweep.run(SPEC.replace(starts=columns).replace(start="1:4:4")), "other.nc")
    assert "they differ in starts" in command("compare other.nc a.nc --common")[2]
    sweep.save(sweep.run(SPEC.replace(starts={"tilt": [0.1] * 5}, roll_rate=3)), "fewer.nc")
    assert "they differ in starts" in command("compare fewer.nc a.nc --common")[2]


@pytest.mark.parametrize("block_cells", [7, 100, 600])
def test_an_array_of_jobs(tmp_path, reference, block_cells):
    """Jobs find the values in the folder, which goes when the file is there."""
    journal = array_jobs.prepare(
        SPEC, tmp_path / "a.nc", block_cells=block_cells, command="sweep.run_to_file"
    )
    assert (journal.folder / STARTS).read_bytes() == SPEC.starts.to_bytes()
    for part in (2, 1):
        array_jobs.compute_part(journal.folder, part, 2)
    array_jobs.assemble(journal.folder)
    assert (tmp_path / "a.nc").read_bytes() == reference
    assert [each.name for each in tmp_path.iterdir()] == ["a.nc"]


def test_the_same_command_goes_on(tmp_path, reference):
    """With the table again; another table is refused."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc", block_cells=100, command="sweep.run_to_file")
    array_jobs.compute_part(journal.folder, 1, 2)
    other = SPEC.replace(starts={**COLUMNS, "tilt": COLUMNS["tilt"][::-1]})
    with pytest.raises(RequestError, match=r"starts: 600 starts of tilt, roll_rate .* there"):
        run_to_file(other, tmp_path / "a.nc")
    said = []
    run_to_file(SPEC, tmp_path / "a.nc", say=said.append)
    assert "going on: 3 of 6 blocks are there, 3 to compute" in said
    assert (tmp_path / "a.nc").read_bytes() == reference


def test_a_stopped_run_whose_table_is_gone(command):
    """The same command has no starts to compare; those that take them from the folder go on."""
    np.savetxt(
        "pushes.csv", np.transpose([*COLUMNS.values()]), "%.17g", ",", header=",".join(COLUMNS), comments=""
    )
    line = "rolling --starts pushes.csv -o a.nc"
    assert command(f"prepare {line} --block-cells 100")[0] == 0
    assert command("block --run a.nc.run --part 1/2")[0] == 0
    Path("pushes.csv").unlink()
    status, _, errors = command(f"run {line}")
    assert (status, "pushes.csv: The table of starts cannot be read" in errors) == (2, True)
    assert command("block --run a.nc.run --part 1/1")[0] == 0
    assert command("assemble a.nc.run")[0] == 0
    with sweep.open_atlas("a.nc") as atlas:
        assert atlas.eulerdisk.spec == SPEC
        assert np.array_equal(atlas.roll_rate, COLUMNS["roll_rate"])


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: path.unlink(),
        lambda path: path.write_bytes(path.read_bytes()[:-8]),
        lambda path: path.write_bytes(path.read_bytes()[:-1] + b"\0"),
        lambda path: path.write_bytes(b"else" + path.read_bytes()),
        lambda path: path.write_bytes(b""),
    ],
)
def test_a_damaged_table_in_the_folder(tmp_path, damage):
    """No block is computed from values that are not those of the run; the file is named, and what to do."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc")
    damage(journal.folder / STARTS)
    with pytest.raises(RequestError) as caught:
        Journal.at(journal.folder)
    assert caught.value.where == str(journal.folder / STARTS)
    assert "manifest" not in str(caught.value)
    assert ".." not in str(caught.value)
    assert "run again with the table" not in str(caught.value)
    assert caught.value.hint.endswith(f"start anew after `rm -r {journal.folder}`.")


def test_killed_before_the_manifest(tmp_path, reference):
    """What a run leaves that was killed while its folder was made is no stranger's."""
    folder = tmp_path / "a.nc.run"
    folder.mkdir()
    (folder / STARTS).write_bytes(b"half")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_bytes() == reference


@pytest.mark.parametrize("spec", [SPEC, RANDOM_SPEC])
def test_a_partial_atlas(tmp_path, spec):
    """The starts of cells that are not computed are there all the same."""
    journal = array_jobs.prepare(spec, tmp_path / "a.nc", block_cells=100)
    array_jobs.compute_part(journal.folder, 1, 3)
    assert write_partial(journal.folder, tmp_path / "part.nc") == (200, 600)
    with sweep.open_atlas(tmp_path / "part.nc") as atlas:
        assert atlas.eulerdisk.spec == spec
        assert np.isfinite(atlas.tilt).all()
        assert atlas.eulerdisk.unstable_share.missing == 400


@pytest.mark.parametrize("value", [0.021, np.nan])
def test_a_changed_start_in_the_file(command, value):
    """Every command that needs the spec refuses the file, and names the columns."""
    Path("a.csv").write_text("tilt [deg],roll_rate\n1,2\n1,3\n")
    assert command("run rolling --starts a.csv -o a.nc")[0] == 0
    with netCDF4.Dataset("a.nc", "a") as file:
        file.set_auto_maskandscale(False)
        file["tilt"][1] = value
    for line in ("info a.nc", "verify a.nc", "explain a.nc start=0", "run --from a.nc -o b.nc"):
        status, _, errors = command(line)
        assert status == 2
        assert "The values of tilt, roll_rate are not those of the starts that were given" in errors


def test_a_steady_rate_follows_from_a_table():
    """Circling: the computed rate is stored beside the columns."""
    spec = sweep.SweepSpec.preset("circling").replace(
        starts={"tilt [deg]": [1.0, 5.0], "precession_rate": [1.0, 3.0]}
    )
    atlas = sweep.run(spec)
    assert atlas.roll_rate.dims == ("start",)
    assert "roll_rate" in atlas.data_vars
    with pytest.raises(RequestError, match="needs a precession_rate"):
        spec.replace(starts={"tilt": [0.1], "precession_rate": [0.0]})
