"""docs/extend.md works: its changes, commands and tests run in a copy of the program."""

import re
import shlex
import shutil

import netCDF4
import pytest
from messages import assert_facts, row
from processes import CHECKOUT
from source_copy import SourceCopy

pytestmark = pytest.mark.slow_lane

PAGE = (CHECKOUT / "docs" / "extend.md").read_text(encoding="utf-8")


def blocks(language):
    """Return the blocks of the page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.M | re.S)


def changes():
    """Return the changes in page order: its blocks, and the diff files that it links to."""
    found = re.finditer(r"^```diff\n(.*?)^```$|\]\((extend/\w+\.diff)\)", PAGE, re.M | re.S)
    return [each[1] or (CHECKOUT / "docs" / each[2]).read_text(encoding="utf-8") for each in found]


def pieces(block):
    """Yield file, old lines and new lines of each hunk of a block of changes."""
    for part in re.split(r"^\+\+\+ ", block, flags=re.M)[1:]:
        file, _, body = part.partition("\n")
        for piece in re.split(r"^@@\n", body, flags=re.M):
            lines = piece.splitlines()
            assert {line[:1] for line in lines} <= {" ", "+", "-"}, piece
            before = "".join(f"{line[1:]}\n" for line in lines if line[0] in " -")
            after = "".join(f"{line[1:]}\n" for line in lines if line[0] in " +")
            yield file, before, after


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """Return a copy of the program with every change of the page applied."""
    copy = SourceCopy(tmp_path_factory.mktemp("fork"))
    (copy.folder / "scripts").mkdir()
    for name in ("figure_cli.py", "make_gallery.py"):
        shutil.copy(CHECKOUT / "scripts" / name, copy.folder / "scripts")
    for block in changes():
        for file, before, after in pieces(block):
            if before:
                copy.edit(file, before, after)
            else:
                (copy.folder / file).write_text(after, encoding="utf-8")
    return copy


def test_every_block_is_known():
    """These tests cover every block of the page."""
    assert set(re.findall(r"^```(\w*)$", PAGE, re.M)) == {"bash", "diff", "python", ""}
    assert {each.splitlines()[0][:8] for each in changes()} == {"+++ kern", "+++ swee", "+++ scri"}
    assert len(changes()) == len(blocks("diff")) + 2
    stored = {path.name for path in (CHECKOUT / "docs" / "extend").iterdir()}
    assert stored == set(re.findall(r"\(extend/([\w.]+)\)", PAGE))


def test_the_files_that_it_names_exist():
    """Every path in the text exists in the project or is created by the page itself."""
    named = set(re.findall(r"`((?:sweep|kernels|tests|scripts|docs)/[\w/.]+)`", PAGE))
    assert len(named) > 10
    assert [name for name in named if not (CHECKOUT / name).exists()] == []


def test_its_changes_fit(fork):
    """Each hunk applies exactly once, and the changed files compile."""
    changed = {file for block in changes() for file, *_ in pieces(block)}
    assert len(changed) > 10
    for file in changed:
        compile((fork.folder / file).read_text(encoding="utf-8"), file, "exec")


@pytest.mark.release
@pytest.mark.compiled
def test_its_commands_run_in_the_fork(fork, tmp_path):
    """They run in page order; each writes the file that it names and reports the new output."""
    lines = [line for block in blocks("bash") for line in block.splitlines()]
    asked = [line.removeprefix("eulerdisk ") for line in lines if line.startswith("eulerdisk ")]
    ends = fork.session(asked, tmp_path)
    assert {line: end for line, end in ends.items() if end[0] != 0} == {}
    drawn = [line for line in lines if line.removeprefix("eulerdisk ") not in ends]
    assert [line.split()[:2] for line in drawn] == [
        ["python", "scripts/plot_falls.py"],
        ["python", "scripts/make_gallery.py"],
    ]
    for line in drawn:
        _, script, *words = shlex.split(line)
        to = ["-o", str(tmp_path)] if "-o" not in words else []
        done = fork.python(str(fork.folder / script), *words, *to, folder=tmp_path)
        assert done.returncode == 0, (line, done.stderr)
    for line in lines:
        words = shlex.split(line)
        if "-o" in words:
            assert (tmp_path / words[words.index("-o") + 1]).stat().st_size > 0
    assert (tmp_path / "falls.png").is_file()
    assert "## How long a disk takes to fall" in (tmp_path / "gallery.md").read_text(encoding="utf-8")
    told = {line: out for line, (_, out, _) in ends.items()}
    assert all(
        "\nverified: " in told[f"verify {name}.nc"] for name in ("swings", "falls", "pressed", "gains")
    )
    assert_facts(row(told["verify swings.nc"], "swing"), "stored")
    assert_facts(row(told["verify falls.nc"], "fall_rate"), "repeated")
    assert_facts(told["info gains.nc"], "20 dB", "perturbation")
    assert told["compare again.nc swings.nc"].startswith("identical")
    assert_facts(told["verify pressed.nc"], "DOP853")
    assert_facts(told["info pressed.nc"], "Circling", "air")


@pytest.mark.release
@pytest.mark.compiled
def test_its_tests_pass_in_the_fork(fork, tmp_path):
    """The tests shown on the page pass with its changes."""
    named = [re.match(r"# (\w+\.py)\n", each)[1] for each in blocks("python")]
    for name, text in zip(named, blocks("python"), strict=True):
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = fork.python("-m", "pytest", "-q", "-p", "no:cacheprovider", *named, folder=tmp_path)
    assert done.returncode == 0, done.stdout
    assert f"{len(named)} passed" in done.stdout


@pytest.mark.release
@pytest.mark.compiled
def test_a_derived_output_is_verified(fork, tmp_path):
    """`verify` finds one wrong value of it; method=exact refuses a criterion that needs the fall."""
    small = "run rolling roll_rate=2:3:4 tilt=1deg,2deg"
    assert fork.command(f"{small} -o grid.nc", tmp_path).returncode == 0
    with netCDF4.Dataset(tmp_path / "grid.nc", "a") as file:
        file["swing"][3, 1] *= 1.0001
    ends = fork.session(
        ["verify grid.nc", f"{small} method=exact criterion=fall_rate>2 -o exact.nc"], tmp_path
    )
    (found, told, _), (refused, _, why) = ends.values()
    assert found == 1
    last = told.splitlines()[-1]
    assert_facts(last, "1 of 8 cells", "swing")
    assert "fall_rate" not in last
    assert refused == 2
    assert_facts(why, "fall_rate", "method=exact")
