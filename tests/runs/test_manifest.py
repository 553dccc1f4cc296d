"""The manifest describes a run and prevents other programs or machines from resuming it wrongly."""

import hashlib
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts, assert_in_order, refused

from sweep.errors import RequestError
from sweep.platforms import processor
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, manifest
from sweep.runs.folder import MANIFEST
from sweep.runs.journal import Journal
from sweep.runs.manifest import Manifest
from sweep.runs.run_directory import check_same_run

CHECKOUT = Path(__file__).parents[2]
SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
AXIS = SweepSpec.from_words("rolling", ["roll_rate=2:4:30:log", "tilt=1deg"])


@pytest.fixture
def written(tmp_path):
    """Return a manifest and its file."""
    made = Manifest.new(SPEC, 5, "2023-11-14T22:13:20Z", "eulerdisk run x.toml")
    made.write(tmp_path / MANIFEST)
    return made, tmp_path / MANIFEST


def test_the_manifest_comes_back(written):
    """A manifest reads back as it was written."""
    made, path = written
    assert Manifest.read(path) == made


def test_the_manifest_says_what_it_is(written):
    """The manifest is readable JSON: spec, blocks, time, command, versions."""
    content = json.loads(written[1].read_text())
    assert content["spec"]["roll_rate"] == 3.0
    assert content["block_cells"] == 5
    assert content["command"] == "eulerdisk run x.toml"
    # It omits the version of eulerdisk, because a release that computes the same bits may resume a run.
    assert set(content["arithmetic"]) == {"format", "arithmetic_hash", "numba", "llvmlite", "numpy"}


def test_the_fingerprint_is_of_what_decides_the_bits(monkeypatch):
    """It depends on spec and code, not on blocks, time or command."""
    one = Manifest.new(SPEC, 5, "t", "c")
    assert Manifest.new(SPEC, 7, "u", "d").fingerprint == one.fingerprint
    assert Manifest.new(SPEC.replace(step=0.001), 5, "t", "c").fingerprint != one.fingerprint
    monkeypatch.setattr(manifest, "arithmetic_hash", lambda _: "0" * 64)
    assert Manifest.new(SPEC, 5, "t", "c").fingerprint != one.fingerprint


def test_differences_are_named(written, monkeypatch):
    """Each differing field is named with both values; the code is compared for the spec of the run."""
    made, _ = written
    assert made.differences(SPEC) == []
    (one,) = made.differences(SPEC.replace(roll_rate=4))
    assert_in_order(one, "roll_rate", "3", "4")
    (close,) = made.differences(SPEC.replace(roll_rate=3.00000000001))
    assert_in_order(close, "roll_rate", "3.0", "3.00000000001")
    (option,) = made.differences(SPEC.replace(contact="yes"))
    assert_in_order(option, "contact", "no", "yes")
    monkeypatch.setattr(manifest, "arithmetic_hash", lambda spec: "0" * 64 if spec == SPEC else "1" * 64)
    for spec in (SPEC, SPEC.replace(contact="yes")):
        *_, last = made.differences(spec)
        assert_in_order(last, "arithmetic_hash", made.arithmetic["arithmetic_hash"][:16], "0" * 16)


def test_a_journal_of_another_format_is_refused(tmp_path, monkeypatch):
    """A run whose blocks have another storage format is not resumed: the message names the format."""
    with monkeypatch.context() as patch:
        patch.setattr(manifest, "FORMAT", 99)
        Journal.create(tmp_path, Manifest.new(SPEC, 5, "t", "c"))
    other = Journal.at(tmp_path)
    with refused("format: 99 in the run", "rm -r"):
        check_same_run(other, SPEC)
    assert other.manifest.fingerprint != Manifest.new(SPEC, 5, "t", "c").fingerprint


def test_a_damaged_manifest_is_refused(written):
    """A truncated, altered or invalid manifest is refused by name, with the remedy."""
    for change in ["cut", "number", "garbage"]:
        _, path = written
        text = path.read_text()
        changed = {
            "cut": text[:-20],
            "number": text.replace(': 5,\n "created"', ': 6,\n "created"'),
            "garbage": "\0" * 99,
        }
        assert changed[change] != text
        path.write_text(changed[change])
        with refused("manifest", "damaged", "rm -r"):
            Manifest.read(path)


def test_a_folder_without_a_run(tmp_path):
    """A folder without a manifest is refused with advice to create one."""
    with refused("eulerdisk prepare"):
        Journal.at(tmp_path)


def test_the_starts_count_to_the_last_bit():
    """If an axis value or a fixed parameter changes in its last bit, the hash changes."""
    before, values = manifest.starts_hash(AXIS), AXIS.roll_rate.array()
    assert manifest.starts_hash(AXIS.replace(roll_rate=values.tolist())) == before
    values[3] = np.nextafter(values[3], 9.0)
    assert manifest.starts_hash(AXIS.replace(roll_rate=values.tolist())) != before
    assert manifest.starts_hash(AXIS.replace(tilt=np.nextafter(AXIS.tilt, 9.0))) != before


def test_the_kind_of_processor_is_the_one_that_kernels_are_compiled_for(monkeypatch):
    """It is LLVM's name of the host, unless the environment names another processor or features."""
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    monkeypatch.delenv("NUMBA_CPU_FEATURES", raising=False)
    assert manifest.machine_facts(AXIS) == {"processor": processor(), "starts": manifest.starts_hash(AXIS)}
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", "+sse4.2")
    assert manifest.machine_facts(AXIS)["processor"] == "generic +sse4.2"


def test_a_part_from_another_kind_of_machine_is_refused(tmp_path, monkeypatch):
    """A machine with another processor or other starts is refused with the difference and the remedy."""
    path = tmp_path / "a.nc"
    array_jobs.prepare(AXIS, path, block_cells=10)
    here = manifest.machine_facts
    for fact in ("processor", "starts"):
        with monkeypatch.context() as patch:
            patch.setattr(manifest, "machine_facts", lambda spec, fact=fact: here(spec) | {fact: "another"})
            with pytest.raises(RequestError) as caught:
                array_jobs.compute_part(tmp_path / "a.nc.run", 1, 3)
            assert_facts(str(caught.value), f"{fact}: {here(AXIS)[fact][:16]} in the run")
            assert "NUMBA_CPU_NAME=x86-64-v3" in caught.value.hint
    assert array_jobs.compute_part(tmp_path / "a.nc.run", 1, 3)
    content = json.loads((tmp_path / "a.nc.run" / MANIFEST).read_text())
    assert content["machine"] == here(AXIS)
    assert Manifest.read(tmp_path / "a.nc.run" / MANIFEST).machine == here(AXIS)


@pytest.mark.release
@pytest.mark.compiled
def test_the_environment_of_the_hint_computes(tmp_path):
    """In the environment that the hint suggests, a run has the named processor."""
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


@pytest.mark.parametrize("value", [0, -1, 1e308, math.inf, 10**400, 3.5, True, None, "x", [], {}])
def test_a_manifest_that_was_edited_is_read_or_refused(written, value):
    """With a valid checksum, a wrong type is refused, and a right one gives differences as text."""
    _, path = written
    content = json.loads(path.read_text())
    places = [(name,) for name in content if name not in ("spec", "checksum")]
    places += [(name, key) for name in ("arithmetic", "recorded", "machine") for key in content[name]]
    read = []
    for place in places:
        edited = json.loads(path.read_text())
        inner = edited
        for name in place[:-1]:
            inner = inner[name]
        inner[place[-1]] = value
        edited.pop("checksum")
        edited["checksum"] = hashlib.sha256(json.dumps(edited, sort_keys=True).encode()).hexdigest()
        path.with_name("edited.json").write_text(json.dumps(edited))
        try:
            manifest = Manifest.read(path.with_name("edited.json"))
        except RequestError:
            continue
        read.append(place)
        assert all(isinstance(each, str) for each in manifest.differences(manifest.spec))
        assert all(isinstance(each, str) for each in manifest.machine_differences())
    texts = {
        place for place in places if len(place) == 2 or place[0] in ("created", "command", "fingerprint")
    }
    numbers = {("block_cells",)} if type(value) is int and value > 0 else set()
    nothing = {("arithmetic",), ("recorded",), ("machine",), ("requested",)} if value == {} else set()
    assert set(read) == (texts if value == "x" else numbers | nothing)
