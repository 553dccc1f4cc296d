"""`batch`: many sweeps in one command, each computed and checked independently of the others."""

import json
import re
import shutil
from contextlib import contextmanager
from xml.etree import ElementTree

import netCDF4
import pytest
import typer
import xarray as xr
from messages import assert_facts, refused

import sweep
from sweep.batch import execution
from sweep.batch.sweeps import read_sweeps
from sweep.errors import StoppedError

SEVERAL = """
tilt = "1deg:4deg:3"
[[sweep]]
name = "disk"
roll_rate = "2:4:5"
[[sweep]]
name = "hoop"
alpha = 1
roll_rate = "1:3:5"
"""


@pytest.fixture
def batch(spec_file, command, tmp_path):
    """Return a function that runs a batch of two sweeps with extra words and returns status, output and messages."""
    spec_file(SEVERAL, "two.toml")
    return lambda words="", specs="two.toml": command(f"batch {specs} -o tonight {words}")


def test_every_sweep_becomes_an_atlas(batch, tmp_path):
    """Each file is the atlas of its spec and records its command; the table has a line for each."""
    status, out, _ = batch("--verify")
    assert status == 0
    lines = out.splitlines()
    assert [line.split()[:4] for line in lines[1:3]] == [
        ["disk", "15", "0", "yes"],
        ["hoop", "15", "0", "yes"],
    ]
    assert_facts(lines[-1], "all 2 sweeps")
    for each in read_sweeps(["two.toml"]):
        with sweep.open_atlas(tmp_path / "tonight" / f"{each.name}.nc") as atlas:
            xr.testing.assert_equal(atlas, sweep.run(each.spec))
            assert atlas.history.endswith("Z eulerdisk batch two.toml -o tonight")


def test_a_sweep_that_misses_the_boundary_is_warned_of(batch, spec_file):
    """Like `run`, `batch` warns if a range is on one side of the predicted boundary in every row."""
    spec_file('radius = 0.012\nroll_rate = "2:4:9"\ntilt = "0.1deg,1deg"\n', "small.toml")
    assert_facts(batch(specs="small.toml")[2], "warning: roll_rate=2.0:4.0:9", "unstable")


def test_a_sweep_of_a_file_of_its_own_can_be_repeated_by_run(batch, spec_file, tmp_path):
    """The history of an atlas contains the `run` command that makes it."""
    spec_file('roll_rate = 3\ntilt = "1deg"\n', "one.toml")
    batch(specs="one.toml")
    with sweep.open_atlas(tmp_path / "tonight" / "one.nc") as atlas:
        assert atlas.history.endswith("Z eulerdisk run one.toml -o tonight/one.nc")


def test_the_same_command_goes_on(batch, spec_file, tmp_path):
    """Finished sweeps are kept and not rewritten; a file by other code is an error unless --overwrite is given."""
    batch()
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "tonight").iterdir()}
    (tmp_path / "tonight" / "hoop.nc").unlink()
    status, out, err = batch()
    assert (status, out.count("(kept)")) == (0, 1)
    assert_facts(err, "disk: kept", "1 of 2 sweeps")
    assert (tmp_path / "tonight" / "disk.nc").stat().st_mtime_ns == before["disk.nc"]
    with netCDF4.Dataset(tmp_path / "tonight" / "disk.nc", "a") as file:
        file.kernel_hash = "0" * 64
    status, out, err = batch()
    assert (status, "another spec" in out) == (1, False)
    assert_facts(out, "disk: tonight/disk.nc", "other code", "--overwrite")
    assert_facts(err, "disk: failed", "1 of 2")
    spec_file(SEVERAL.replace("2:4:5", "2:4:6"), "two.toml")
    assert_facts(batch()[1], "disk: tonight/disk.nc", "another spec", "other code", "--overwrite")
    spec_file(SEVERAL, "two.toml")
    assert batch("--overwrite")[0] == 0
    with sweep.open_atlas(tmp_path / "tonight" / "disk.nc") as atlas:
        assert atlas.kernel_hash != "0" * 64


def test_a_stop_ends_the_batch_and_keeps_what_is_finished(batch, tmp_path):
    """A stop between two sweeps keeps the finished one, and the next call continues."""
    (tmp_path / "tonight").mkdir()
    sweeps, done = read_sweeps(["two.toml"]), []
    options = execution.Options(tmp_path / "tonight")
    with refused("1 of 2 sweeps", error=StoppedError):
        done.extend(
            execution.carry_out(sweeps, options, stopping=lambda: (tmp_path / "tonight" / "disk.nc").exists())
        )
    assert [each.state for each in execution.carry_out(sweeps, options)] == [
        execution.KEPT,
        execution.COMPUTED,
    ]


def test_every_step_tells_its_own_progress(batch, tmp_path):
    """Each step starts without a remaining time, so that none from the previous step is shown."""
    batch("")
    shutil.copytree(tmp_path / "tonight", tmp_path / "trusted")
    heard, folder = [], tmp_path / "again"
    folder.mkdir()
    options = execution.Options(folder, verify=True, reference=tmp_path / "trusted")
    list(execution.carry_out(read_sweeps(["two.toml"]), options, show=heard.append))
    stages = [each.stage for each in heard]
    first = [heard[stages.index(name)] for name in ("compiling the kernels", "verify", "compare")]
    assert [(each.size, each.seconds) for each in first] == [(0, None)] * 3
    assert stages.count("compiling the kernels") == stages.count("verify") == stages.count("compare") == 2
    assert {"verify: checking", "compare: comparing"} < {*stages}
    last = max(i for i, each in enumerate(heard) if each.stage == "verify: checking")
    assert (heard[last].done, heard[last].size) == (15, 15)


def test_what_fails_in_one_sweep_stops_no_other(batch, spec_file, monkeypatch, tmp_path):
    """A bad spec, a defect and too little memory are reported; the other sweeps run, and the status is 1."""
    spec_file("rol_rate = 3\n", "bad.toml")
    spec_file('roll_rate = 3\ntilt = "1deg"\n', "defect.toml")
    spec_file('roll_rate = 3\ntilt = "2deg"\n', "memory.toml")
    run = execution.run_to_file

    def failing(spec, path, **rest):
        errors = {"defect.nc": ValueError("odd"), "memory.nc": MemoryError()}
        if path.name in errors:
            raise errors[path.name]
        return run(spec, path, **rest)

    monkeypatch.setattr(execution, "run_to_file", failing)
    status, out, err = batch("--verify", specs="bad.toml defect.toml memory.toml two.toml")
    assert status == 1
    # an error in a spec is reported once, at the beginning
    assert err.count("bad.toml: rol_rate: ") == 1
    assert "rol_rate" not in out
    assert any(line.split()[:3] == ["bad", "-", "refused"] for line in out.splitlines())
    problems = {line.partition(": ")[0]: line for line in out.splitlines() if ": " in line}
    assert_facts(problems["defect"], "eulerdisk", "ValueError: odd")
    assert_facts(problems["memory"], "memory")
    assert_facts(out, "3 of 5 sweeps")
    assert "Traceback" in err
    assert {path.name for path in (tmp_path / "tonight").iterdir()} == {"disk.nc", "hoop.nc"}


@pytest.mark.slow_lane
def test_every_atlas_is_compared_with_the_trusted_one_of_its_name(batch, tmp_path):
    """Atlases are compared with trusted ones of the same name; the status is 1 if one differs or is missing."""
    batch()
    (tmp_path / "tonight").rename(tmp_path / "trusted")
    assert batch("--reference trusted")[0] == 0
    with netCDF4.Dataset(tmp_path / "trusted" / "hoop.nc", "a") as file:
        file["tilt_max"][...] = 0.5
    status, out, err = batch("--reference trusted --junit found.xml")
    assert status == 1
    lines = out.splitlines()
    assert ("identical" in lines[1], "DIFFERENT in tilt_max" in lines[2]) == (True, True)
    (told,) = (line for line in out.splitlines() if line.startswith("hoop: "))
    facts = "tilt_max", "15 of 15", "2e-08", "eulerdisk compare tonight/hoop.nc trusted/hoop.nc"
    assert_facts(told, *facts)
    assert re.search(r" 0\.[\d]+ rad\b", told)
    assert_facts(err, "hoop: kept", "(compare)", "2 of 2")
    root = ElementTree.parse(tmp_path / "found.xml").getroot()
    assert (root.get("tests"), root.get("failures")) == ("4", "1")
    assert [case.get("name") for case in root.iter("testcase")] == ["run", "compare"] * 2
    times = [float(each.get("time")) for each in root.iter("testcase")]
    assert sum(times) == pytest.approx(float(root.get("time")), abs=0.003)
    assert max(times) > 0.0
    assert told == f"hoop: {root.find('.//failure').get('message')}"
    (tmp_path / "trusted" / "hoop.nc").unlink()
    status, out, _ = batch("--reference trusted --json")
    found = json.loads(out)
    assert (status, found["fine"]) == (1, False)
    assert [each["fine"] for each in found["sweeps"]] == [True, False]
    assert_facts(found["sweeps"][1]["problems"]["compare"], "cp tonight/hoop.nc trusted/hoop.nc")
    assert found["sweeps"][0]["comparison"]["outcome"] == "identical"


def test_an_atlas_that_states_what_is_wrong_is_not_verified(batch, tmp_path):
    """An atlas without a wrong cell but with a wrong attribute gives status 1 and the attribute's name."""
    batch()
    with netCDF4.Dataset(tmp_path / "tonight" / "hoop.nc", "a") as file:
        file.license = "mine"
    status, out, _ = batch("--verify")
    assert (status, out.splitlines()[2].split()[4]) == (1, "WRONG")
    (told,) = (line for line in out.splitlines() if line.startswith("hoop: "))
    assert_facts(told, "0 cells", "wrong: license")


def test_cells_that_could_not_be_computed_are_counted(batch, spec_file):
    """More failed cells than --max-failed give status 1."""
    # no roll rate keeps a disk tilted without precession: invalid
    spec_file('tilt = "1deg:4deg:3"\nprecession_rate = "0:1:2"\nroll_rate = "steady"\n', "odd.toml")
    status, out, _ = batch(specs="odd.toml")
    assert status == 1
    (told,) = (line for line in out.splitlines() if line.startswith("odd: "))
    assert_facts(told, "3 of 6 cells", "(50 %)", "3 invalid")
    assert batch("--max-failed 50", specs="odd.toml")[0] == 0


def test_bad_words_are_refused(batch, command, tmp_path):
    """Bad words give status 2, and nothing is written."""
    for words, facts in [
        ("batch two.toml -o two.toml/x", ["two.toml/x", "Not a directory"]),
        ("batch two.toml -o /proc/x", ["/proc/x", "No such file"]),
        (f"batch two.toml -o {'a' * 300}", ["File name too long"]),
        ("batch rolling -o tonight --threads 0", ["threads", "0"]),
    ]:
        status, out, err = command(words)
        assert (status, out) == (2, "")
        assert_facts(err, *facts)
        assert [path.name for path in tmp_path.iterdir()] == ["two.toml"]


def test_a_name_that_is_wrong_is_the_problem_of_its_sweep(command, spec_file, tmp_path):
    """A sweep with a missing, bad or duplicate name is reported by its position; the others run."""
    spec_file(
        'tilt = "1deg"\n[[sweep]]\nroll_rate = 2\n[[sweep]]\nname = "a"\nroll_rate = 3\n'
        '[[sweep]]\nname = "A"\nroll_rate = 4\n[[sweep]]\nname = "../b"\nroll_rate = 4\n',
        "b.toml",
    )
    status, out, err = command("batch b.toml -o tonight --junit found.xml --json")
    assert status == 1
    found = json.loads(out)["sweeps"]
    names = ["b.toml, [[sweep]] 1", "a", "b.toml, [[sweep]] 3", "b.toml, [[sweep]] 4"]
    assert [(each["name"], each["state"]) for each in found] == list(
        zip(names, ["refused", "computed", "refused", "refused"], strict=True)
    )
    assert [each["file"] for each in found] == [None, "tonight/a.nc", None, None]
    assert_facts(err, "b.toml, [[sweep]] 3", "name A")
    assert [path.name for path in (tmp_path / "tonight").iterdir()] == ["a.nc"]
    root = ElementTree.parse(tmp_path / "found.xml").getroot()
    assert [each.get("name") for each in root] == names
    assert (root.get("failures"), root.get("errors")) == ("3", "0")


def test_a_batch_in_which_all_is_refused_is_reported(command, spec_file, tmp_path):
    """If all sweeps are refused, the status is 2 and a requested report replaces an older one."""
    spec_file("rol_rate = 3\n", "bad.toml")
    (tmp_path / "found.xml").write_text("<testsuites/>")
    status, out, err = command("batch bad.toml -o tonight --junit found.xml")
    assert (status, out, err.count("rol_rate: ")) == (2, "", 1)
    assert "rol_rate" in ElementTree.parse(tmp_path / "found.xml").getroot().find(".//failure").get("message")
    status, out, _ = command("batch bad.toml -o tonight --json")
    assert (status, json.loads(out)["fine"]) == (2, False)
    assert not (tmp_path / "tonight").exists()


def test_a_report_of_a_batch_that_was_cut_off_says_so(batch, tmp_path, monkeypatch):
    """The report starts with an error for each sweep; after an interrupt, those of unfinished sweeps remain."""
    (tmp_path / "found.xml").write_text("<testsuites/>")
    run, seen = execution.run_to_file, []

    def interrupted(spec, path, **rest):
        seen.append(ElementTree.parse(tmp_path / "found.xml").getroot().get("errors"))
        if path.name == "hoop.nc":
            raise StoppedError("now")
        return run(spec, path, **rest)

    @contextmanager
    def stopping(status):
        try:
            yield lambda: False
        except StoppedError:
            raise typer.Exit(status) from None

    monkeypatch.setattr(execution, "run_to_file", interrupted)
    monkeypatch.setattr("sweep.commands.batch.stoppable", lambda: stopping(130))
    assert batch("--junit found.xml")[0] == 130
    assert seen == ["2", "2"]
    root = ElementTree.parse(tmp_path / "found.xml").getroot()
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("2", "0", "1")
    assert [each.find(".//error") is None for each in root] == [True, False]
    assert root.find(".//error").get("message")


def test_another_grid_of_the_trusted_atlas(batch, spec_file, tmp_path):
    """The advice for a trusted atlas with another grid does not mention --common, which `batch` lacks."""
    batch()
    (tmp_path / "tonight").rename(tmp_path / "trusted")
    spec_file(SEVERAL.replace("2:4:5", "2:4:6"), "two.toml")
    status, out, _ = batch("--reference trusted")
    assert (status, "--common" in out) == (1, False)
    assert_facts(out, "disk: trusted/disk.nc", "grid", "replace")


@pytest.mark.parametrize(
    ("words", "target"),
    [
        ("--junit two.toml", "two.toml"),
        ("--junit tonight/disk.nc", "tonight/disk.nc"),
        ("--reference trusted --junit trusted/hoop.nc", "trusted/hoop.nc"),
        ("--reference trusted --junit ./tonight/../trusted/hoop.nc", "trusted/hoop.nc"),
    ],
)
def test_a_report_replaces_neither_a_spec_nor_an_atlas(batch, tmp_path, words, target):
    """A report never replaces a spec or an atlas."""
    batch()
    shutil.copytree(tmp_path / "tonight", tmp_path / "trusted")
    before = (tmp_path / target).read_bytes()
    status, out, err = batch(words)
    assert (status, out) == (2, "")
    assert_facts(err, "--junit", target)
    assert (tmp_path / target).read_bytes() == before


def test_a_report_may_lie_in_the_folder_that_the_batch_makes(batch, tmp_path):
    """The report may be in the batch's own folder, even before the folder exists."""
    assert batch("--junit tonight/found.xml")[0] == 0
    assert ElementTree.parse(tmp_path / "tonight" / "found.xml").getroot().get("tests") == "2"
