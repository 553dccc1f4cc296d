"""The journal: blocks come back bit by bit, damage is noticed, and a folder belongs to one run and one writer."""

import errno
import fcntl
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sweep.engine.compute import compute
from sweep.errors import RequestError
from sweep.model.disk.audit import DERIVED
from sweep.request.spec import SweepSpec
from sweep.runs import journal, locks, manifest
from sweep.runs.journal import DamagedBlockError, Journal
from sweep.runs.locks import locked
from sweep.runs.manifest import Manifest
from sweep.runs.run_directory import check_same

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    """Return a journal of four blocks, one of them kept."""
    folder = tmp_path_factory.mktemp("a.nc.run")
    made = Manifest.new(SPEC, 5, "2023-11-14T22:13:20Z", "eulerdisk run x.toml")
    made.write(folder / journal.MANIFEST)
    book = Journal(folder, made)
    journal.keep(2, compute(SPEC, journal.spans[2]))
    return book


def test_a_block_comes_back(book):
    """Every column is read as it was written, bit by bit; NumPy alone reads what is stored of it."""
    columns = compute(SPEC, journal.spans[2])
    (path,) = journal.held()[2]
    block = journal.read(2, path)
    assert block.span == journal.spans[2]
    assert list(block.columns) == list(columns)
    with np.load(path) as archive:
        for name, column in columns.items():
            assert (block.columns[name].dtype, block.columns[name].tobytes()) == (
                column.dtype,
                column.tobytes(),
            )
            if name in archive:
                assert np.array_equal(np.resize(archive[name], column.shape), column, equal_nan=True)
        assert set(archive) == set(columns) - set(DERIVED)


def test_a_block_has_one_file_whoever_writes_it(book):
    """Written again, by whomever, a block has the same name and bytes: duplicates do no harm."""
    (path,) = journal.held()[2]
    before = path.read_bytes()
    journal.keep(2, compute(SPEC, journal.spans[2]))
    assert journal.held() == {2: [path]}
    assert path.read_bytes() == before


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damage_is_noticed(book, data):
    """A block that is cut anywhere, ends in zeros from anywhere, or has any one bit flipped, is refused."""
    (path,) = journal.held()[2]
    good = path.read_bytes()
    place = data.draw(st.integers(0, len(good) - 1))
    kind = data.draw(st.sampled_from(["cut", "zeros", "bit"]))
    if kind == "cut":
        bad = good[:place]
    elif kind == "zeros":
        bad = good[:place] + bytes(len(good) - place)
    else:
        bad = good[:place] + bytes([good[place] ^ 1 << data.draw(st.integers(0, 7))]) + good[place + 1 :]
    path.write_bytes(bad)
    try:
        if bad != good:
            with pytest.raises(DamagedBlockError):
                journal.read(2, path)
    finally:
        path.write_bytes(good)


def test_a_block_of_another_place_or_run_is_noticed(book):
    """A block under another number, or of another run, does not fit its name."""
    (path,) = journal.held()[2]
    with pytest.raises(DamagedBlockError, match="does not fit"):
        journal.read(1, path)
    other = Journal(journal.folder, Manifest.new(SPEC.replace(roll_rate=4), 5, "t", "c"))
    with pytest.raises(DamagedBlockError, match="does not fit"):
        other.read(2, path)


def test_what_is_damaged_is_set_aside(book):
    """Verifying names the damaged block, keeps its file under another name, and counts it as missing."""
    columns = compute(SPEC, journal.spans[0])
    journal.keep(0, columns)
    (path,) = journal.held()[0]
    path.write_bytes(path.read_bytes()[:-2])
    sound, damaged = journal.verify()
    assert sound == {2}
    assert len(damaged) == 1
    assert path.name in damaged[0]
    assert path.with_name(path.name + ".damaged").is_file()
    assert journal.missing(journal.held()) == [0, 1, 3]


def test_two_results_for_one_block_are_trusted_neither(book):
    """If two machines computed a block differently, both files are set aside and it is computed again."""
    columns = dict(compute(SPEC, journal.spans[3]))
    journal.keep(3, columns)
    columns["tilt_max"] = np.nextafter(columns["tilt_max"], 9)
    journal.keep(3, columns)
    assert len(journal.held()[3]) == 2
    sound, damaged = journal.verify([3])
    assert sound == set()
    assert "twice with different results" in damaged[0]
    assert 3 not in journal.held()


def test_a_refused_write_leaves_nothing(book, monkeypatch):
    """If the file system refuses a block half way, no part of it stays."""

    def refuse(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    before = sorted(journal.folder.rglob("*"))
    monkeypatch.setattr("sweep.files.publish.os.fsync", refuse)
    with pytest.raises(OSError, match="No space"):
        journal.keep(1, compute(SPEC, journal.spans[1]))
    assert sorted(journal.folder.rglob("*")) == before


def test_the_manifest_comes_back(book):
    """What a run is reads as it was written."""
    assert Manifest.read(journal.folder / journal.MANIFEST) == journal.manifest


def test_the_fingerprint_is_of_what_decides_the_bits(monkeypatch):
    """It depends on spec and kernels, not on blocks, time or command."""
    one = Manifest.new(SPEC, 5, "t", "c")
    assert Manifest.new(SPEC, 7, "u", "d").fingerprint == one.fingerprint
    assert Manifest.new(SPEC.replace(step=0.001), 5, "t", "c").fingerprint != one.fingerprint
    monkeypatch.setattr(manifest.compiled, "kernel_hash", lambda: "0" * 64)
    assert Manifest.new(SPEC, 5, "t", "c").fingerprint != one.fingerprint


def test_differences_are_named(book, monkeypatch):
    """Each field that differs is named with both values, the program's too."""
    assert journal.manifest.differences(SPEC) == []
    (one,) = journal.manifest.differences(SPEC.replace(roll_rate=4))
    assert one == "roll_rate: 3.0 there, 4.0 here"
    monkeypatch.setattr(manifest.compiled, "kernel_hash", lambda: "0" * 64)
    (two,) = journal.manifest.differences(SPEC)
    assert two.startswith("kernel_hash: ")
    assert two.endswith("0000000000000000 here")


def test_a_journal_of_another_format_is_refused(tmp_path, monkeypatch):
    """A run begun by a program that stored blocks otherwise is not gone on with: the format is named."""
    monkeypatch.setattr(manifest, "FORMAT", 1)
    made = Manifest.new(SPEC, 5, "t", "c")
    made.write(tmp_path / journal.MANIFEST)
    monkeypatch.undo()
    older = Journal.at(tmp_path)
    with pytest.raises(RequestError, match=r"blocks of another run.*format: 1 there, 2 here.*rm -r"):
        check_same(older, SPEC)
    assert older.manifest.fingerprint != Manifest.new(SPEC, 5, "t", "c").fingerprint


@pytest.mark.parametrize("change", ["cut", "number", "garbage"])
def test_a_damaged_manifest_is_refused(book, tmp_path, change):
    """A manifest that is cut, altered or no JSON is refused under its name, with what to do."""
    path = tmp_path / journal.MANIFEST
    text = (journal.folder / journal.MANIFEST).read_text()
    changed = {
        "cut": text[:-20],
        "number": text.replace(': 5,\n "created"', ': 6,\n "created"'),
        "garbage": "\0" * 99,
    }
    assert changed[change] != text
    path.write_text(changed[change])
    with pytest.raises(RequestError, match=r"manifest.*damaged.*rm -r"):
        Manifest.read(path)


def test_a_folder_without_a_run(tmp_path):
    """A folder that holds no manifest is refused, with how to make one."""
    with pytest.raises(RequestError, match=r"not the folder of a run.*eulerdisk prepare"):
        Journal.at(tmp_path)


_HOLD = """
import sys, time
from pathlib import Path
from sweep.runs.locks import locked
with locked(Path(sys.argv[1]), shared=sys.argv[2] == "shared"):
    print("held", flush=True)
    time.sleep(60)
"""


def holding(folder, how="alone"):
    """Start a process that holds the lock."""
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(folder), how],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
        stdout=subprocess.PIPE,
        text=True,
    )
    with process.stdout as out:
        assert out.readline() == "held\n"
    return process


def test_one_writer_at_a_time(tmp_path):
    """While a process holds the lock another is refused, with process, machine and time; kill -9 lets go of it."""
    process = holding(tmp_path)
    for shared in (False, True):
        with (
            pytest.raises(RequestError, match=rf"being written.*process {process.pid} on .* since 20"),
            locked(tmp_path, shared=shared),
        ):
            pass
    process.kill()
    process.wait()
    with locked(tmp_path):
        pass


def test_array_jobs_share_the_lock(tmp_path):
    """Those who ask for it shared hold it together; who wants it alone is refused."""
    process = holding(tmp_path, "shared")
    with locked(tmp_path, shared=True):
        pass
    with pytest.raises(RequestError, match="being written"), locked(tmp_path):
        pass
    process.kill()
    process.wait()


def test_a_file_system_without_locks(tmp_path, monkeypatch):
    """There a file that only one can make stands in; that of a dead process here is cleared away, others are named."""

    def unsupported(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", unsupported)
    with locked(tmp_path):
        assert (tmp_path / "owner").is_file()
        with pytest.raises(RequestError, match=rf"process {os.getpid()} on .*rm .*owner"), locked(tmp_path):
            pass
        with locked(tmp_path, shared=True):
            pass
    assert not (tmp_path / "owner").exists()
    gone = subprocess.Popen(["true"])
    gone.wait()
    words = locks._signature().split()
    (tmp_path / "owner").write_text(" ".join([words[0], str(gone.pid), *words[2:]]))
    with locked(tmp_path):
        pass
    (tmp_path / "owner").write_text(" ".join([*words[:3], "elsewhere", *words[4:]]))
    with pytest.raises(RequestError, match="on elsewhere"), locked(tmp_path):
        pass


def test_the_manifest_says_what_it_is(book):
    """The manifest is JSON that a person can read: spec, blocks, time, command, versions."""
    content = json.loads((journal.folder / journal.MANIFEST).read_text())
    assert content["spec"]["roll_rate"] == 3.0
    assert content["block_cells"] == 5
    assert content["command"] == "eulerdisk run x.toml"
    assert set(content["arithmetic"]) == {"format", "eulerdisk", "kernel_hash", "numba", "llvmlite", "numpy"}
