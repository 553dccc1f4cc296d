"""A program that computes the same bits can resume an unfinished run; one that might not is refused."""

import re
from pathlib import Path

import pytest
import xarray as xr
from messages import assert_facts
from source_copy import SourceCopy

from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs
from sweep.runs.run import run_to_file

WORDS = ["roll_rate=2:4:4", "tilt=1deg"]
SPECS = {
    "rk4": SweepSpec.from_words("rolling", WORDS),
    "contact": SweepSpec.from_words("rolling", [*WORDS, "contact=yes"]),
    "steady": SweepSpec.from_words("circling", ["tilt=5deg", "precession_rate=0.1:5:4"]),
    "exact": SweepSpec.from_words("rolling", [*WORDS, "method=exact"]),
}

#: Changes that affect no bit of an rk4 run: comments, docstrings, messages, the version, unused kernels.
HARMLESS = [
    ("kernels/disk/rk4.py", "# a division would cost a tenth of the step", "# another comment"),
    (
        "kernels/lanes/schedule.py",
        "The model's functions are declared in",
        "A model's functions are declared in",
    ),
    (
        "sweep/model/disk/initial_conditions.py",
        "rates that the spec leaves to the cell",
        "rates that a spec leaves to the cell",
    ),
    ("sweep/request/sources.py", '"A range must have count', '"The range must have count'),
    ("sweep/engine/grid.py", "BLOCK_CELLS = 2**17", "BLOCK_CELLS = 2**16"),
    ("kernels/bodies/motion_arrays.py", '"friction_along"', '"friction_ahead"'),
    ("sweep/version.py", '__version__ = "', '__version__ = "99.'),
    ("kernels/reduction/turning.py", "_EPS = 2.0**-52", "_EPS = 2.0**-51"),
    ("kernels/reduction/contact_extremes.py", "_KNOWN = 2.5e-7", "_KNOWN = 2.5e-8"),
    ("sweep/figures/scales.py", "SQUEEZED = 20.0", "SQUEEZED = 30.0"),
]

#: Changes that affect the bits of a run: equations, starts, axis values, kernels of method and options.
DECISIVE = [
    (
        "rk4",
        "kernels/disk/equations.py",
        "0.5 * alpha, 1.0 / (1.0 + alpha)",
        "0.6 * alpha, 1.0 / (1.0 + alpha)",
    ),
    (
        "steady",
        "sweep/model/disk/initial_conditions.py",
        "steady_precession_rates(tilt, starts",
        "steady_roll_rate(tilt, starts",
    ),
    ("rk4", "sweep/request/sources.py", "return np.linspace(", "return np.geomspace("),
    ("contact", "kernels/reduction/contact_extremes.py", "_KNOWN = 2.5e-7", "_KNOWN = 2.5e-8"),
    ("exact", "kernels/reduction/turning.py", "_EPS = 2.0**-52", "_EPS = 2.0**-51"),
]


def computed(folder, spec, parts):
    """Prepare a run of two blocks with this program, and compute parts 1 to `parts` of 2."""
    folder.mkdir()
    journal = array_jobs.prepare(spec, folder / "a.nc", block_cells=2)
    for part in range(1, parts + 1):
        assert array_jobs.compute_part(journal.folder, part, 2) == (0, 1)


@pytest.mark.slow_lane
def test_what_decides_no_bit_may_change(tmp_path):
    """The changed program assembles the stored blocks into the file of an undisturbed run, bit for bit."""
    # All blocks are stored, so the changed program need not compile; it checks the run's identity before.
    computed(tmp_path / "run", SPECS["rk4"], 2)
    copy = SourceCopy(tmp_path / "copy")
    for file, before, after in HARMLESS:
        copy.edit(file, before, after)
    done = copy.command(f"run rolling {' '.join(WORDS)} -o a.nc", tmp_path / "run")
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert_facts(done.stderr, "2 of 2 blocks", "0")
    run_to_file(SPECS["rk4"], tmp_path / "whole.nc")
    with xr.open_dataset(tmp_path / "run" / "a.nc") as found, xr.open_dataset(tmp_path / "whole.nc") as whole:
        assert "99." in found.attrs["source"]
        assert found.attrs["kernel_hash"] == whole.attrs["kernel_hash"]
        for name, variable in whole.variables.items():
            assert found[name].values.tobytes() == variable.values.tobytes(), name


@pytest.mark.slow_lane
def test_what_decides_the_bits_may_not_change(tmp_path):
    """With status 2 the code is named as the difference, and nothing is computed or removed."""
    for kind, file, before, after in DECISIVE:
        folder = tmp_path / Path(file).stem
        folder.mkdir()
        computed(folder / "run", SPECS[kind], 1)
        kept = sorted((folder / "run").rglob("*"))
        copy = SourceCopy(folder / "copy")
        copy.edit(file, before, after)
        done = copy.command("block --run a.nc.run --part 2/2", folder / "run")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), file
        assert re.search(r"\barithmetic_hash\b.*\b[0-9a-f]{16}\b.*\b[0-9a-f]{16}\b", done.stderr), file
        assert_facts(done.stderr, "rm -r a.nc.run")
        assert sorted((folder / "run").rglob("*")) == kept, file
