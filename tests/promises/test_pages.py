"""Every command on every page of the site is run by a test, here or where a table below says; what is not is named.

A command is a line of a block of bash, or a piece of code in a sentence that begins as one. What has an upper-case
word or three dots in it stands for many commands: of these the program has to know the name and the options.
"""

import glob
import re
import shlex
from pathlib import Path

import pytest

from sweep.motion.preset import is_preset, request_of_preset
from sweep.motion.request import TrajectorySpec, split_motion_words
from sweep.request.spec import SweepSpec

CHECKOUT = Path(__file__).parents[2]
DOCS = CHECKOUT / "docs"
#: The pages whose commands are for a reader; a changelog tells of commands as they were.
PAGES = {path.name: path for path in sorted(DOCS.glob("*.md"))} | {
    "CONTRIBUTING.md": CHECKOUT / "CONTRIBUTING.md"
}

#: Page and language of blocks -> the test that runs all of them.
BLOCKS_RUN_BY = {
    ("architecture.md", "python"): "tests/models/test_bead.py::test_docs_walk_through_this_model",
    ("batch.md", "toml"): "tests/promises/test_pages.py::test_the_page_on_batches",
    ("batch.md", "bash"): "tests/promises/test_pages.py::test_the_page_on_batches",
    ("commands.md", "bash"): "tests/promises/test_commands_page.py::test_commands",
    ("commands.md", "toml"): "tests/promises/test_commands_page.py::test_spec_file",
    ("explore.md", "bash"): "tests/promises/test_explorer_page.py::test_its_commands_run",
    ("explore.md", "python"): "tests/promises/test_explorer_page.py::test_its_python_runs",
    ("extend.md", "bash"): "tests/promises/test_extend_page.py::test_its_commands_run_in_the_fork",
    ("extend.md", "diff"): "tests/promises/test_extend_page.py::test_its_commands_run_in_the_fork",
    ("extend.md", "python"): "tests/promises/test_extend_page.py::test_its_tests_pass_in_the_fork",
    ("figures.md", "bash"): "tests/figures/test_figures_page.py::test_its_commands_run",
    ("figures.md", "python"): "tests/figures/test_figures_page.py::test_its_python_runs",
    ("gallery.md", "bash"): "tests/promises/test_pages.py::test_the_gallery_asks_for_what_there_is",
    ("index.md", "python"): "tests/promises/test_site.py::test_the_start_page_runs",
    ("losses.md", "bash"): "tests/promises/test_losses_page.py::test_its_commands_run",
    (
        "motions.md",
        "bash",
    ): "tests/promises/test_motion_page.py::test_its_commands_are_requests_that_can_be_met",
    ("motions.md", "python"): "tests/promises/test_motion_page.py::test_its_python_runs",
    ("python.md", "python"): "tests/promises/test_public_names.py::test_its_python_runs",
    ("interruption.md", "python"): "tests/promises/test_public_names.py::test_its_interruption_runs",
    ("names.md", "text"): "tests/promises/test_public_names.py::test_every_public_name_is_listed",
    ("starts.md", "bash"): "tests/promises/test_starts_page.py::test_commands_of_the_page",
    ("tables.md", "bash"): "tests/promises/test_starts_page.py::test_commands_of_the_page",
    ("tables.md", "csv"): "tests/promises/test_starts_page.py::test_commands_of_the_page",
    ("tables.md", "python"): "tests/promises/test_starts_page.py::test_python_of_the_page",
    ("words.md", "bash"): "tests/promises/test_words_page.py::test_its_commands_run",
    ("another-disk.md", "bash"): "tests/promises/test_words_page.py::test_its_commands_run",
    (
        "another-disk.md",
        "text",
    ): "tests/promises/test_words_page.py::test_its_refusal_is_the_one_of_the_program",
    ("another-disk.md", "python"): "tests/promises/test_words_page.py::test_its_python_runs",
}

#: Commands that no test runs as they stand -> why, or the test that runs them otherwise. Audits are run with other
#: numbers again and again.
EXCEPTED = {
    "dask scheduler &": "a server; tests/runs/test_dask_executor.py starts one of its own",
    "dask worker tcp://scheduler:8786 &": "a server",
    "eulerdisk run rolling -o atlas.nc --dask tcp://scheduler:8786": "asks that server",
    "pip install 'eulerdisk[dask]'": "installs; tests/promises/test_packaging.py",
    "pip install jupyterlab": "installs what is not ours",
    "pip install .": "installs; tests/promises/test_packaging.py",
    "source .venv/bin/activate": "changes a shell",
    "cp tonight/hoop.nc trusted/": "test_the_page_on_batches does it",
    "scripts/atlas": "tests/promises/test_readme.py::test_atlas_command",
    "scripts/test": "this test run",
    "scripts/test tests/request -k unit": "this test run",
    "scripts/test -n 0": "this test run",
    "scripts/test --readers": "asks for a password",
    "scripts/javascript/check": "a part of scripts/test",
    "python scripts/explorer_random_use.py --minutes N --seed N hoop.nc": "minutes; "
    "tests/explorer/browser/test_random_use.py",
    "scripts/explorer_random_use.py": "minutes; tests/explorer/browser/test_random_use.py",
    "scripts/record_explorer.py": "minutes, and writes pictures of the docs",
    "scripts/vendor_page.py": "fetches from npm; tests/explorer/test_vendor.py holds what it fetched",
    "scripts/site": "tests/promises/test_site.py",
    "scripts/fuzz": "long",
    "scripts/soak": "long",
    "scripts/gallery": "minutes; tests/scripts/test_make_gallery.py draws coarse ones",
    "python scripts/plot_report.py -o docs/report": "a minute; tests/promises/test_report_page.py has its numbers",
    "python scripts/plot_convergence.py -o docs/convergence.png": "minutes; tests/studies/test_convergence.py",
    "python scripts/audit_extremes.py errors N N": "an hour; tests/scripts/test_audit_extremes.py",
    "python scripts/audit_extremes.py separatrices N N": "minutes; tests/scripts/test_audit_extremes.py",
    "python scripts/audit_extremes.py brackets N N": "minutes; tests/scripts/test_audit_extremes.py",
    "python scripts/audit_extremes.py periods N N": "minutes; tests/scripts/test_audit_extremes.py",
    "python scripts/audit_contact.py random N N": "minutes; tests/scripts/test_audit_contact.py",
    "python scripts/audit_compare.py N N": "minutes; tests/scripts/test_audit_compare.py",
    "python scripts/benchmark.py": "many minutes; tests/scripts/test_benchmark.py",
    "python scripts/audit_losses.py mixtures N N": "minutes; tests/lossy_referee.py is its referee in the tests too",
    "python scripts/audit_losses.py single N N": "minutes; likewise",
    "python scripts/audit_losses.py breaches N N": "minutes; likewise",
    "python scripts/audit_losses.py tight N N": "seconds, after minutes of compiling; likewise",
    "python scripts/audit_losses.py grazes N N": "minutes; likewise",
    "python scripts/audit_losses.py passes N N": "minutes; likewise",
    "python scripts/audit_losses.py wobbles": "likewise",
    "python scripts/audit_losses.py limits N N": "likewise",
    "python scripts/audit_losses.py holding N N": "likewise",
    "scripts/audit_extremes.py errors N N": "an hour; tests/scripts/test_audit_extremes.py",
    "scripts/audit_compare.py N N": "minutes; tests/scripts/test_audit_compare.py",
    "scripts/audit_contact.py": "minutes; tests/scripts/test_audit_contact.py",
    "scripts/damage.py": "a module of scripts/fuzz.py",
    "explore toy.nc": "a server; tests/explorer/test_explorer.py opens one of such an atlas",
    "scripts/make_gallery.py": "minutes; tests/scripts/test_make_gallery.py",
    "pytest --eulerdisk-regen": "tests/test_pytest_plugin.py",
    "python -m pytest tests/promises/test_golden.py --eulerdisk-regen": "writes the files of reference anew",
}

#: Command -> those that make the files it reads, small.
_GRID = "tilt=1deg:3deg:3 roll_rate=2:4:6"
_RANDOM = "run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=200 seed=7 -o random.nc"
_PUSHED = "prepare rolling --starts pushes.csv -o pushes.nc"
BEFORE = {
    "plot three.nc alpha=0.5 -o slice.png": [f"run rolling alpha=0.2,0.5 {_GRID} -o three.nc"],
    "boundary three.nc alpha=0.5 -o slice.nc": [f"run rolling alpha=0.2,0.5 {_GRID} -o three.nc"],
    "boundary a.nc --to csv": [f"run rolling {_GRID} -o a.nc"],
    "export a.nc --to csv": [f"run rolling {_GRID} -o a.nc"],
    "info fall.nc": ["simulate radius=12mm tilt=1deg duration=2s -o fall.nc"],
    "run --from pushes.nc": ["run rolling --starts pushes.csv -o pushes.nc"],
    "block --run pushes.nc.run --part 1/1": [_PUSHED],
    "assemble pushes.nc.run": [_PUSHED, "block --run pushes.nc.run --part 1/1"],
    "plot random.nc start=0:99 -o part.png": [_RANDOM],
    "simulate --from random.nc start=17": [_RANDOM],
    "run --from random.nc start=0:99": [_RANDOM],
    "run --from atlas.nc radius=12mm": [f"run rolling {_GRID} -o atlas.nc"],
    "plot speeds.nc speed=18cm/s:25cm/s -o part.png": [
        "run rolling speed=15cm/s:30cm/s:9 radius=12mm tilt=1deg:3deg:3 -o speeds.nc"
    ],
}

_ALIASES = (
    "run",
    "plan",
    "batch",
    "plot",
    "info",
    "boundary",
    "verify",
    "compare",
    "explain",
    "simulate",
    "export",
)


_AUDIT = re.compile(r"\bscripts/(?:audit_|explorer_random_use)")


def blocks(page):
    """Return language and text of the blocks of code of a page; what Sphinx reads is none."""
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGES[page].read_text(encoding="utf-8"), re.M | re.S)
    return [(language, text) for language, text in found if language]


def in_sentences(page):
    """Return the commands in the sentences and tables of a page, `eulerdisk` taken off."""
    text = re.sub(r"^```.*?^```$", "", PAGES[page].read_text(encoding="utf-8"), flags=re.M | re.S)
    spans = [" ".join(each.split()) for each in re.findall(r"`([^`]+)`", text)]
    program = rf"eulerdisk |(?:{'|'.join(_ALIASES)}) [^ ]|(?:pip|python|pytest|source|cp) |scripts/\w"
    found = [each.removeprefix("eulerdisk ") for each in spans if re.match(program, each)]
    return [re.sub(r"\b\d+\b", "N", each) if _AUDIT.search(each) else each for each in found]


def uncommented(text):
    """Return the commands of a block of bash."""
    return [line for each in text.splitlines() if (line := re.sub(r"(^|\s+)#.*", "", each).strip())]


SENTENCES = [
    (page, each) for page in PAGES for each in dict.fromkeys(in_sentences(page)) if each not in EXCEPTED
]
#: What stands for many commands, or names one with an option.
NAMED = [
    each
    for each in SENTENCES
    if re.search(r"\.\.\.|\b[A-Z]{2,}\b", each[1]) or not re.search(r"=|\.nc\b", each[1])
]
WHOLE = [each for each in SENTENCES if each not in NAMED]


def test_no_block_escapes():
    """Each block is run by the test that the table names, or its commands are among those run or excepted here."""
    for page in PAGES:
        for language, text in blocks(page):
            if (page, language) in BLOCKS_RUN_BY:
                continue
            assert language == "bash", (page, language)
            if text.startswith("#!/bin/bash\n#SBATCH"):
                continue  # tests/runs/test_array_jobs.py::test_the_documented_array_job
            left = [
                line for line in uncommented(text) if line not in EXCEPTED and (page, line) not in RUN_HERE
            ]
            assert left == [], page


def test_the_tests_that_run_blocks_exist():
    """Every test of the table, and of the reasons, is there, and every exception is still on a page."""
    named = [*BLOCKS_RUN_BY.values(), *re.findall(r"tests/[\w/.:]+", " ".join(EXCEPTED.values()))]
    for each in named:
        file, _, test = each.partition("::")
        assert (CHECKOUT / file).is_file(), file
        assert f"def {test}(" in (CHECKOUT / file).read_text(encoding="utf-8") if test else True, each
    used = {each for page in PAGES for each in in_sentences(page)}
    used |= {
        line
        for page in PAGES
        for language, text in blocks(page)
        if language == "bash"
        for line in uncommented(text)
    }
    assert [each for each in EXCEPTED if each not in used] == []
    assert {(page, language) for page in PAGES for language, _ in blocks(page)} >= BLOCKS_RUN_BY.keys()
    assert {each for _, each in WHOLE} >= BEFORE.keys()


def test_scripts_of_sentences_exist():
    """Every script that a command runs is one of the project."""
    for each in EXCEPTED:
        for script in re.findall(r"scripts/[\w/]+(?:\.py)?", each):
            assert (CHECKOUT / script).is_file(), each


@pytest.mark.parametrize(("page", "line"), NAMED)
def test_a_named_command_and_its_options_are_known(command, page, line):
    """`eulerdisk plot --friction 0.5` in a sentence: the program has the command, and the command the option."""
    first, *words = line.split()
    if first.startswith("-"):
        assert command(first)[0] == 0
        return
    status, told, _ = command(f"{first} --help")
    assert status == 0
    assert [word for word in words if word.startswith("--") and word not in told] == []


@pytest.mark.compiled
@pytest.mark.parametrize(("page", "line"), WHOLE)
def test_a_command_of_a_sentence_runs(command, tmp_path, page, line):
    """It ends well, and leaves the file that it names."""
    (tmp_path / "pushes.csv").write_text("roll_rate [rad/s],tilt [deg]\n2.5,1.0\n3.1,0.5\n", encoding="utf-8")
    for each in BEFORE.get(line, []):
        assert command(each)[0] == 0, each
    words = line.split()
    needs = words[0] in ("run", "simulate") and "-o" not in words and "--help" not in words
    status, _, err = command(f"{line} -o made.nc" if needs else line)
    assert status == 0, err
    if needs or "-o" in words:
        assert (tmp_path / ("made.nc" if needs else words[words.index("-o") + 1])).stat().st_size > 0


#: Commands of blocks that are run here, as they stand.
RUN_HERE = [
    (page, line)
    for page in ("atlas.md", "cells.md", "lossy.md", "report.md")
    for language, text in blocks(page)
    if language == "bash"
    for line in uncommented(text)
    if line not in EXCEPTED
]


@pytest.mark.compiled
@pytest.mark.parametrize("page", sorted({page for page, _ in RUN_HERE}))
def test_blocks_of_other_pages_run(command, tmp_path, page):
    """In the order of the page; each leaves the files that it names."""
    for line in (line for each, line in RUN_HERE if each == page):
        program, *words = shlex.split(line)
        assert program == "eulerdisk", line
        status, _, err = command(shlex.join(words))
        assert status == 0, (line, err)
        for option in ("-o", "--plot"):
            if option in words:
                assert (tmp_path / words[words.index(option) + 1]).stat().st_size > 0


@pytest.mark.compiled
def test_the_page_on_batches(command, tmp_path):
    """The file of the page is computed, kept as reference, and held against it by the command of the page."""
    (toml,) = (text for language, text in blocks("batch.md") if language == "toml")
    (line,) = (
        line for language, text in blocks("batch.md") if language == "bash" for line in text.splitlines()
    )
    for folder in ("sweeps", "trusted"):
        (tmp_path / folder).mkdir()
    (tmp_path / "sweeps" / "two.toml").write_text(toml.replace(":100:log", ":9:log"), encoding="utf-8")
    words = [shlex.join(sorted(glob.glob(word)) or [word]) for word in shlex.split(line)[1:]]
    assert command(" ".join(words[: words.index("--reference")]))[0] == 0
    for name in ("disk", "hoop"):
        (tmp_path / "trusted" / f"{name}.nc").write_bytes((tmp_path / "tonight" / f"{name}.nc").read_bytes())
    status, told, err = command(" ".join(words))
    assert status == 0, err
    assert re.search(r"^hoop .*identical", told, re.M)


def test_the_gallery_asks_for_what_there_is(command):
    """Its scripts exist; of its other commands the words are read as the program reads them, the options are known."""
    lines = [line for _, text in blocks("gallery.md") for line in text.splitlines()]
    assert len(lines) > 20
    for line in lines:
        program, *words = shlex.split(line)
        assert program == "python", line
        if words[:2] != ["-m", "sweep"]:
            assert (CHECKOUT / words[0]).is_file(), line
            continue
        first, *rest = words[2:]
        told = command(f"{first} --help")[1]
        assert [word for word in rest if word.startswith("--") and word not in told] == [], line
        given = [word for word in rest if "=" in word]
        if first == "run":
            SweepSpec.from_words(rest[0], given)
        elif first == "simulate" and is_preset(rest[0]):
            request_of_preset(rest[0], split_motion_words(given))
        elif first == "simulate":
            TrajectorySpec.from_words(given)
        else:
            assert first == "plot"
