"""Errors of requests: one line of place, message and hint, an exit status, and pickling between processes."""

import pickle

from sweep.errors import FailedBlocksError, RequestError, StoppedError, StorageError

TEXTS = ("roll_rate must be finite; got nan.", "Write roll_rate=2.5.", "roll_rate")


def test_an_error_is_one_line_of_place_message_and_hint():
    """Each part has its attribute; omitted parts leave no trace."""
    error = RequestError(*TEXTS)
    assert (error.message, error.hint, error.where) == TEXTS
    assert str(error) == "roll_rate: roll_rate must be finite; got nan. Write roll_rate=2.5."
    assert str(RequestError("tilt must be finite; got nan.")) == "tilt must be finite; got nan."


def test_a_long_place_is_shortened_in_the_midst():
    """Its start and end identify the file; the sentence remains complete."""
    text = str(RequestError(TEXTS[0], where="/data/" + "x" * 4000 + "/a.nc"))
    assert text.startswith("/data/xxx")
    assert text.endswith(f"xxx/a.nc: {TEXTS[0]}")
    assert len(text) < 600


def test_an_error_is_sent_between_processes_and_placed():
    """A pickled error keeps kind, text and status; `at` changes only its place."""
    for kind, status in [(RequestError, 2), (StorageError, 3), (FailedBlocksError, 1)]:
        for texts in [TEXTS, TEXTS[:2], TEXTS[:1]]:
            error = kind(*texts)
            back = pickle.loads(pickle.dumps(error))
            assert (type(back), str(back), back.status) == (kind, str(error), status)
            moved = error.at("a.toml")
            assert type(moved) is kind
            assert str(moved) == f"a.toml: {error.message} {error.hint}".rstrip()


def test_a_stopped_run_says_where_its_blocks_are():
    """Its message with the finished and total blocks survives pickling."""
    assert str(pickle.loads(pickle.dumps(StoppedError("3 of 8 blocks are kept")))) == "3 of 8 blocks are kept"
