"""The journal: blocks come back bit for bit, and all damage is detected."""

import errno
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from messages import assert_facts, refused

from sweep.engine.compute import compute, derive_block, measure_block
from sweep.engine.grid import Span, starts_of
from sweep.request.spec import SweepSpec
from sweep.runs.journal import DamagedBlockError, Journal, decode, encode
from sweep.runs.manifest import Manifest

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)

ROLLING = SweepSpec(roll_rate="0.5:6:30", tilt="0.01deg:60deg:20:log")
CIRCLING = {"roll_rate": "steady", "precession_rate": "-5:5:30", "tilt_rate": 0.01}

SPECS = {
    "rolling": ROLLING,
    "short": ROLLING.replace(duration=0.05),
    "exact": ROLLING.replace(method="exact"),
    "contact": ROLLING.replace(contact="yes"),
    "criterion": ROLLING.replace(criterion="amplification:3"),
    "circling": SweepSpec(tilt="-20deg:20deg:21", **CIRCLING),
    "steady-slow": SweepSpec(tilt="1deg:20deg:20", roll_rate="-9:5:30", precession_rate="steady-slow"),
    "no axis": SweepSpec(tilt="1deg", roll_rate=3),
    "failing": ROLLING.replace(step=0.3),
}


@pytest.fixture
def journal(tmp_path):
    """Return a journal of four blocks, one of them stored."""
    journal = Journal.create(tmp_path, Manifest.new(SPEC, 5, "2023-11-14T22:13:20Z", "eulerdisk run x.toml"))
    journal.keep(2, measure_block(SPEC, journal.spans[2]))
    return journal


def assert_same_columns(found, expected):
    """Check that names, order, types and bits are the same."""
    assert list(found) == list(expected)
    for name, column in expected.items():
        assert (name, found[name].dtype, found[name].shape) == (name, column.dtype, column.shape)
        assert (name, found[name].tobytes()) == (name, column.tobytes())


def test_a_block_comes_back(journal):
    """Columns read back unchanged, even in another process, from the manifest and the file."""
    again = Journal.at(journal.folder)
    (path,) = again.held()[2]
    assert_same_columns(again.read(2, [path]), measure_block(SPEC, journal.spans[2]))


def test_a_block_that_is_written_twice_has_one_file(journal):
    """A block written again has the same name and bytes, so duplicates do no harm."""
    (path,) = journal.held()[2]
    before = path.read_bytes()
    journal.keep(2, measure_block(SPEC, journal.spans[2]))
    assert journal.held() == {2: [path]}
    assert path.read_bytes() == before


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damage_is_noticed(journal, data):
    """A block that is truncated, zeroed from any position, or has any one bit flipped is refused."""
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
                journal.read(2, [path])
    finally:
        path.write_bytes(good)


def test_a_block_of_another_place_or_run_is_noticed(journal):
    """A block under another number, of another run or another division does not match its name."""
    (path,) = journal.held()[2]
    others = [
        (1, journal),
        (2, Journal(journal.folder, Manifest.new(SPEC.replace(roll_rate=4), 5, "t", "c"))),
        (2, Journal(journal.folder, Manifest.new(SPEC, 4, "t", "c"))),
    ]
    for number, other in others:
        with refused("checksum", error=DamagedBlockError):
            other.read(number, [path])


def test_what_is_damaged_is_set_aside(journal):
    """`verify` names the damaged block, renames its file, and counts it as missing."""
    journal.keep(0, measure_block(SPEC, journal.spans[0]))
    (path,) = journal.held()[0]
    path.write_bytes(path.read_bytes()[:-2])
    missing, damaged = journal.verify(range(4))
    assert missing == [0, 1, 3]
    assert len(damaged) == 1
    assert path.name in damaged[0]
    assert path.with_name(path.name + ".damaged").is_file()
    assert journal.held().keys() == {2}


def test_neither_of_two_results_for_one_block_is_trusted(journal):
    """If two machines computed a block differently, both files are set aside and the block is recomputed."""
    columns = dict(measure_block(SPEC, journal.spans[3]))
    journal.keep(3, columns)
    columns["tilt_max"] = np.nextafter(columns["tilt_max"], 9)
    journal.keep(3, columns)
    assert len(journal.held()[3]) == 2
    missing, damaged = journal.verify([3])
    assert missing == [3]
    assert_facts(damaged[0], "twice")
    assert 3 not in journal.held()


def test_all_blocks_in_order_or_none(journal):
    """Reading the whole journal gives every block once, in order; a missing block is an error."""
    for number in (3, 0):
        journal.keep(number, measure_block(SPEC, journal.spans[number]))
    with refused("block 1", error=DamagedBlockError):
        list(journal.blocks())
    journal.keep(1, measure_block(SPEC, journal.spans[1]))
    blocks = list(journal.blocks())
    assert [number for number, _ in blocks] == [0, 1, 2, 3]
    for number, columns in blocks:
        assert_same_columns(columns, measure_block(SPEC, journal.spans[number]))


def test_a_refused_write_leaves_nothing(journal, monkeypatch):
    """If the file system refuses a block halfway, no part of it stays."""

    def refuse(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    before = sorted(journal.folder.rglob("*"))
    monkeypatch.setattr("sweep.files.publish.os.fsync", refuse)
    with pytest.raises(OSError, match="No space"):
        journal.keep(1, measure_block(SPEC, journal.spans[1]))
    assert sorted(journal.folder.rglob("*")) == before


def test_columns_come_back():
    """After encoding, decoding and deriving, the columns equal the computed ones, for any cells."""
    for share in [1.0, 0.4, 0.01]:
        for spec in SPECS.values():
            middle, half = spec.size // 2, int(spec.size * share / 2)
            span = Span(middle - half, max(middle + half, middle - half + 1))
            measured = measure_block(spec, span)
            back = decode(encode(measured, spec.shape[-1] if spec.axes else 1), len(span))
            assert_same_columns(back, measured)
            assert_same_columns(derive_block(spec, span, back), compute(spec, starts_of(spec, span)))


def stored(content):
    """Return what a block's header lists: name -> (stored type, number of values)."""
    return {name: (kind, count) for name, _, kind, count in json.loads(content.partition(b"\n")[0])}


def test_what_repeats_is_stored_once():
    """Constants are one value, columns equal in every row are one row; counts have the smallest type."""
    content = encode(measure_block(SPECS["short"], Span(7, 600)), 20)
    found = stored(content)
    for name in ("ending", "fall_time", "nutation_period", "refinements"):
        assert found[name][1] == 1, name
    # Released at rest, every motion starts from an extreme tilt.
    assert found["tilt_min"][1] == 20
    assert found["steps"][0] in ("|i1", "|u1")
    assert len(content) < 18 * 593 + 900


def test_one_cell_makes_the_difference():
    """A column of zeros except for one cell or bit is not taken for a repeating one."""
    for place in [0, 7, 299, 598, 599]:
        for name, value in [
            ("tilt_max", -0.0),
            ("tilt_max", np.nan),
            ("fall_time", 1.0),
            ("ending", 5),
            ("steps", -129),
            ("steps", 70000),
        ]:
            columns = {
                each: np.zeros_like(column) for each, column in measure_block(ROLLING, Span(0, 600)).items()
            }
            columns[name][place] = value
            assert_same_columns(decode(encode(columns, 20), 600), columns)


def test_two_kinds_of_nan_are_two_values():
    """NaN with other bits is another value."""
    period = np.full(600, np.nan)
    period.view(np.uint64)[300] += 1
    assert_same_columns(decode(encode({"period": period}, 20), 600), {"period": period})


def test_a_block_has_a_number_in_ascii(journal):
    """Digits of other scripts are not a block number."""
    (journal.folder / "blocks" / "\uff11-00000000.block").touch()
    assert list(journal.held()) == [2]
