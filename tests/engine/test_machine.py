"""What decides the bits on a machine is probed, recorded with a run, and has to be the same where the run goes on."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sweep.engine import machine
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs
from sweep.runs.journal import Journal
from sweep.runs.manifest import Manifest
from sweep.runs.names import MANIFEST
from sweep.runs.run import run_to_file
from sweep.runs.run_directory import check_same_run

CHECKOUT = Path(__file__).parents[2]
WORDS = ["roll_rate=2:4:30:log", "tilt=1deg"]
SPEC = SweepSpec.from_words("rolling", WORDS)
X86 = platform.machine().lower() in ("x86_64", "amd64")


def command(words, folder, **environment):
    """Run a command line in an environment and return what came of it."""
    return subprocess.run(
        [sys.executable, "-m", "sweep", *words.split()],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_probe_sees_what_changes_a_bit(monkeypatch):
    """The hash is that of the results, one bit of one of them changes it; Python itself has no fused multiply-add."""
    fused, rounding = machine._rounding.__wrapped__()
    assert fused in ("yes", "no")
    assert len(rounding) == 64
    assert machine._rounding.__wrapped__() == (fused, rounding)

    class Plain:
        def load(self):
            import kernels.rounding

            return kernels.rounding.probe.py_func

    monkeypatch.setattr(machine, "_PROBE", Plain())
    assert machine._rounding.__wrapped__()[0] == "no"


def test_the_starts_are_hashed_to_the_bit(monkeypatch):
    """The last bit of one value of an axis, or of one completed start, gives another hash; the words do not."""
    before = machine.starts_hash(SPEC)
    values = SPEC.roll_rate.array()
    assert machine.starts_hash(SPEC.replace(roll_rate=values.tolist())) == before
    values[17] = np.nextafter(values[17], 9.0)
    assert machine.starts_hash(SPEC.replace(roll_rate=values.tolist())) != before
    assert machine.starts_hash(SPEC.replace(tilt=np.nextafter(SPEC.tilt, 9.0))) != before


@pytest.mark.parametrize("fact", ["fused_multiply_add", "rounding", "starts"])
def test_a_part_from_another_kind_of_machine_is_refused(tmp_path, monkeypatch, fact):
    """Whatever part of the run, the message names what differs and the way out, and nothing is computed."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc", block_cells=15)
    kept = sorted(tmp_path.rglob("*"))
    here = machine.facts
    monkeypatch.setattr(machine, "facts", lambda spec: here(spec) | {fact: "something else"})
    for go_on in (
        lambda: array_jobs.compute_part(journal.folder, 1, 2),
        lambda: array_jobs.assemble(journal.folder),
        lambda: run_to_file(SPEC, tmp_path / "a.nc"),
    ):
        with pytest.raises(
            RequestError, match=rf"would compute other bits.*{fact}: \w+ there, something else here"
        ):
            go_on()
    with pytest.raises(RequestError, match="--baseline generic"):
        check_same_run(Journal.at(journal.folder), SPEC)
    assert sorted(tmp_path.rglob("*")) == kept


@pytest.mark.skipif(not X86, reason="every processor of this architecture has fused multiply-add")
def test_a_processor_without_fused_multiply_add_takes_no_part(tmp_path):
    """Simulated by the compiler's settings: the block is refused with status 2 and one sentence."""
    array_jobs.prepare(SPEC, tmp_path / "a.nc", block_cells=15)
    done = command(
        "block --run a.nc.run --part 1/2", tmp_path, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES=""
    )
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "fused_multiply_add: yes there, no here" in done.stderr
    assert list((tmp_path / "a.nc.run" / "blocks").iterdir()) == []


@pytest.mark.skipif(not X86, reason="the names are those of x86-64")
def test_a_common_baseline_is_that_of_every_part(tmp_path):
    """It is recorded with the values of logarithmic axes; parts take it from there, also where their own would differ.

    The command starts itself again for it: the recorded probe is that of a processor without fused multiply-add.
    """
    done = command(f"prepare rolling {' '.join(WORDS)} -o a.nc --block-cells 15 --baseline generic", tmp_path)
    assert done.returncode == 0, done.stderr
    path = tmp_path / "a.nc.run" / MANIFEST
    content = json.loads(path.read_text())
    assert (content["baseline"], content["machine"]["fused_multiply_add"]) == ("generic", "no")
    assert content["axes"] == {"roll_rate": SPEC.roll_rate.array().tolist()}
    # another machine whose logarithms differ in the last bit reads the values of the first
    manifest = Manifest.read(path)
    content["axes"]["roll_rate"][3] = np.nextafter(content["axes"]["roll_rate"][3], 9.0)
    other = machine.with_axes(SPEC, content["axes"])
    assert other.canonical() == SPEC.canonical()
    assert other.roll_rate.array().tolist() == content["axes"]["roll_rate"] != SPEC.roll_rate.array().tolist()
    assert manifest.spec.roll_rate.array().tolist() == SPEC.roll_rate.array().tolist()
    assert "baseline" in manifest.versions
    with pytest.raises(RequestError, match=r"not started for it.*NUMBA_CPU_NAME='generic'"):
        array_jobs.compute_part(path.parent, 1, 2)
    with pytest.raises(RequestError, match="baseline: generic there, none here"):
        run_to_file(SPEC, tmp_path / "a.nc", baseline="")


def test_a_baseline_that_cannot_be(monkeypatch):
    """An unknown name is refused with the known ones, and one whose instructions this processor lacks by them."""
    with pytest.raises(RequestError, match=r"no baseline 'i386'.*generic, x86-64-v3"):
        machine.environment("i386")
    monkeypatch.setattr("sweep.platforms.host_features", lambda: {"avx2": True, "bmi2": True})
    with pytest.raises(RequestError, match="lacks fma"):
        machine.environment("x86-64-v3")
    assert machine.environment("") == {}
