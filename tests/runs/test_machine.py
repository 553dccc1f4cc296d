"""What decides the bits on a machine is recorded with a run, and has to be the same where the run goes on."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sweep.errors import RequestError
from sweep.platforms import processor
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, manifest
from sweep.runs.folder import MANIFEST
from sweep.runs.manifest import Manifest

CHECKOUT = Path(__file__).parents[2]
SPEC = SweepSpec.from_words("rolling", ["roll_rate=2:4:30:log", "tilt=1deg"])


def test_the_starts_count_to_the_last_bit():
    """A value of an axis or a fixed parameter that differs in its last bit has another hash."""
    before, values = manifest.starts_hash(SPEC), SPEC.roll_rate.array()
    assert manifest.starts_hash(SPEC.replace(roll_rate=values.tolist())) == before
    values[3] = np.nextafter(values[3], 9.0)
    assert manifest.starts_hash(SPEC.replace(roll_rate=values.tolist())) != before
    assert manifest.starts_hash(SPEC.replace(tilt=np.nextafter(SPEC.tilt, 9.0))) != before


def test_the_kind_of_processor_is_the_one_that_kernels_are_compiled_for(monkeypatch):
    """It is LLVM's name of this one, unless the environment names another one or other features."""
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    monkeypatch.delenv("NUMBA_CPU_FEATURES", raising=False)
    assert manifest.machine_facts(SPEC) == {"processor": processor(), "starts": manifest.starts_hash(SPEC)}
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", "+sse4.2")
    assert manifest.machine_facts(SPEC)["processor"] == "generic +sse4.2"


def test_a_part_from_another_kind_of_machine_is_refused(tmp_path, monkeypatch):
    """A machine with another processor, or other starts, is refused with what differs and what to set."""
    path = tmp_path / "a.nc"
    array_jobs.prepare(SPEC, path, block_cells=10)
    here = manifest.machine_facts
    for fact in ("processor", "starts"):
        with monkeypatch.context() as patch:
            patch.setattr(manifest, "machine_facts", lambda spec, fact=fact: here(spec) | {fact: "another"})
            with pytest.raises(RequestError) as caught:
                array_jobs.compute_part(tmp_path / "a.nc.run", 1, 3)
            assert f"{fact}: {here(SPEC)[fact][:16]} there, another here" in str(caught.value)
            assert "NUMBA_CPU_NAME=x86-64-v3" in caught.value.hint
    assert array_jobs.compute_part(tmp_path / "a.nc.run", 1, 3)
    content = json.loads((tmp_path / "a.nc.run" / MANIFEST).read_text())
    assert content["machine"] == here(SPEC)
    assert Manifest.read(tmp_path / "a.nc.run" / MANIFEST).machine == here(SPEC)


@pytest.mark.compiled
def test_the_environment_of_the_hint_computes(tmp_path):
    """A run in the environment that the refusal gives is a run of that kind of processor."""
    line = f"{manifest.SAME_BITS} {sys.executable} -m sweep prepare rolling roll_rate=2:4:30:log -o a.nc"
    done = subprocess.run(
        line,
        shell=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    if "which this processor does not have" in done.stderr or "; this processor does not" in done.stderr:
        pytest.skip("this processor is older")
    assert done.returncode == 0, done.stderr
    content = json.loads((tmp_path / "a.nc.run" / MANIFEST).read_text())
    assert content["machine"]["processor"] == "x86-64-v3"
