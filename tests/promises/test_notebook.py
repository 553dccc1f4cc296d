"""In a notebook run by Jupyter's own client: an automatic bar, safe interrupts, and summaries."""

import os
import re
import warnings
from pathlib import Path

import pytest
from messages import assert_facts

with warnings.catch_warnings():
    # jupyter_client and zmq emit their own warnings.
    warnings.simplefilter("ignore")
    import nbformat
    from nbclient import NotebookClient

pytestmark = pytest.mark.release

CHECKOUT = Path(__file__).parents[2]
BEGIN = """
import os, signal, threading
import sweep
spec = sweep.SweepSpec.preset("rolling").replace(
    roll_rate="2:4:400", tilt="0.01deg:5deg:300", step=1e-4, tolerance=1e-3)
sweep.run("rolling", roll_rate=3, tilt=0.1, progress=False)  # loads the kernels

def interrupted_by(jupyter, seconds=1.5):
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()
"""
CELLS = {
    "begin": BEGIN,
    "short": "small = sweep.run('rolling', roll_rate='2:4:9', tilt='0.1deg:5deg:5')",
    "interrupted": "interrupted_by('the button')\natlas = sweep.run(spec)",
    "again": "dones = []\natlas = sweep.run(spec, progress=lambda each: dones.append(each.done))\nprint(dones[0])",
    "file interrupted": "interrupted_by('the button')\nsweep.run_to_file(spec, 'a.nc')",
    "left": "print(sorted(os.listdir()))",
    "file": "sweep.run_to_file(spec, 'a.nc', progress=True)",
    "same": "sweep.compare(sweep.open_atlas('a.nc'), atlas, exact=True).identical",
    "summary": "small.eulerdisk",
    "figure": "small.eulerdisk.plot()",
    "figure with pyplot": "import matplotlib.pyplot as plt\nplt.figure()\nplt.close()\nsmall.eulerdisk.plot()",
}


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Return the outputs of every cell by cell name."""
    folder = tmp_path_factory.mktemp("notebook")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(each) for each in CELLS.values()])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        NotebookClient(
            book,
            timeout=300,
            allow_errors=True,
            kernel_name="python3",
            resources={"metadata": {"path": str(folder)}},
        ).execute(env={**os.environ, "PYTHONPATH": str(CHECKOUT)})
    return {name: cell.outputs for name, cell in zip(CELLS, book.cells, strict=True)}


def shown(outputs, kind="text/html"):
    """Return what a cell displays."""
    return [each.data[kind] for each in outputs if each.output_type in ("display_data", "execute_result")]


def raised(outputs):
    """Return the error that ends a cell."""
    (found,) = [each for each in outputs if each.output_type == "error"]
    return f"{found.ename}: {found.evalue}"


@pytest.mark.compiled
def test_nothing_is_said_of_short_work(outputs):
    """A small sweep leaves no bar in the notebook."""
    assert outputs["begin"] == outputs["short"] == []


@pytest.mark.compiled
def test_a_bar_comes_by_itself(outputs):
    """The computing cell gets one bar, which stays as it was after an interrupt."""
    (bar,) = shown(outputs["interrupted"])
    assert "computing" in bar
    assert "finished" not in bar
    assert not [each for each in outputs["interrupted"] if each.output_type == "stream"]


@pytest.mark.compiled
def test_an_interrupted_sweep_in_memory_keeps_nothing(outputs):
    """The interrupt says so and recommends a run to a file; the next call starts from scratch."""
    said = raised(outputs["interrupted"])
    (stream,) = outputs["again"]
    assert stream.text == "0\n"
    assert said.startswith("KeyboardInterrupt: ")
    assert_facts(said, "120000 cells", "nothing", "sweep.run_to_file")


@pytest.mark.compiled
def test_an_interrupted_file_goes_on(outputs):
    """Finished blocks are kept next to the file; the same call then completes the bit-identical atlas."""
    assert re.search(r"\bblocks?\b", raised(outputs["file interrupted"]))
    assert_facts(raised(outputs["file interrupted"]), "a.nc.run")
    assert outputs["left"][0].text == "['a.nc.run']\n"
    bar, said = shown(outputs["file"], "text/plain")
    assert "finished after" in bar
    assert_facts(said, "all", "120000 cells")
    assert shown(outputs["same"], "text/plain") == ["True"]


@pytest.mark.compiled
def test_an_atlas_is_shown(outputs):
    """The accessor displays a table and a small map."""
    (found,) = shown(outputs["summary"])
    assert "<table" in found
    assert "<svg" in found


@pytest.mark.compiled
@pytest.mark.parametrize("cell", ["figure", "figure with pyplot"])
def test_a_figure_is_shown(outputs, cell):
    """It is one picture, whether or not pyplot has configured the notebook's figures."""
    (found,) = shown(outputs[cell], "image/png")
    assert found.startswith("iVBOR")
