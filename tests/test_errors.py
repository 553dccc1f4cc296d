"""Errors of requests: one line of where, message and hint, an exit status, and a way between processes."""

import pickle

import pytest

from sweep.errors import FailedBlocksError, RequestError, StoppedError, StorageError

NEW = ("roll_rate must be finite; got nan.", "Write roll_rate=2.5.", "roll_rate")
OLD = ("not a finite number", "a value is finite", "nan", "write roll_rate=2.5", "roll_rate")


def test_an_error_is_one_line_of_place_message_and_hint():
    """Each part has its attribute; what is not given leaves no trace."""
    error = RequestError(*NEW)
    assert (error.message, error.hint, error.where) == NEW
    assert str(error) == "roll_rate: roll_rate must be finite; got nan. Write roll_rate=2.5."
    assert str(RequestError("tilt must be finite; got nan.")) == "tilt must be finite; got nan."


def test_the_older_form_reads_the_same_way():
    """Four texts and a place become a message and a hint, and keep their names."""
    error = RequestError(*OLD)
    assert str(error) == ("roll_rate: not a finite number: a value is finite; got nan. write roll_rate=2.5.")
    assert (error.what, error.rule, error.given, error.do, error.where) == OLD
    question = RequestError("unknown word", "known words", "rol", "did you mean roll?")
    assert str(question).endswith("got rol. did you mean roll?")
    assert RequestError(*OLD).at("tilt", "tilt=nan").given == "tilt=nan"
    error.rule += " or steady"
    assert "is finite or steady; got" in str(error)


@pytest.mark.parametrize("texts", [NEW, OLD, NEW[:2], NEW[:1], OLD[:4]])
@pytest.mark.parametrize(("kind", "status"), [(RequestError, 2), (StorageError, 3), (FailedBlocksError, 1)])
def test_an_error_is_sent_between_processes_and_placed(kind, status, texts):
    """A pickled error comes back with kind, text and status; `at` moves it and changes nothing else."""
    error = kind(*texts)
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), back.status) == (kind, str(error), status)
    moved = error.at("a.toml")
    assert type(moved) is kind
    assert str(moved) == f"a.toml: {error.message} {error.hint}".rstrip()


def test_a_stopped_run_says_where_its_blocks_are():
    """Folder, finished blocks and all blocks come back from another process."""
    back = pickle.loads(pickle.dumps(StoppedError("a.nc.run", 3, 8)))
    assert (back.folder, back.done, back.blocks) == ("a.nc.run", 3, 8)
