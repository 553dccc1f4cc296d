"""What a run will take: its time from what was measured, and its bytes on disk as it then takes them."""

from collections import namedtuple
from pathlib import Path

import pytest

from sweep.engine import estimate
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.runs import forecast, journal
from sweep.runs.forecast import Forecast, check_room
from sweep.runs.run import run_to_file

MILLION = SweepSpec(roll_rate="1:4:1000", tilt="1deg:5deg:1000")


def test_the_time_of_a_run():
    """A million cells cost a second of one processor beside their computation; start and search are added."""
    for rate, threads, processors, expected in [
        (1e3, 1, 2, 1000.0),  # computing is all
        (1e9, 1, 2, 1.0),  # one thread keeps what is computed
        (1e9, 2, 2, 0.5),  # two do
        (1e6, 1, 2, 1.0),  # both at once
        (1e6, 2, 2, 1.5),  # both at once, on the same processors
        (1e6, 1, 1, 2.0),  # one after the other
        (1e6, 8, 64, 1.0),
    ]:
        found = Forecast(rate, 1e-6, 20.0, 30.0, 0.4, 0.25)
        assert found.seconds(MILLION, threads, processors) - 0.65 == pytest.approx(expected, rel=3e-3)


@pytest.fixture
def peak(monkeypatch):
    """Return a function that runs a spec and returns the bytes of the whole journal and of the file."""

    def of(spec, path):
        taken = []
        publish = journal.publish_bytes
        with monkeypatch.context() as context:
            context.setattr(
                journal, "publish_bytes", lambda *given: (taken.append(len(given[1])), publish(*given))
            )
            run_to_file(spec, path)
        return sum(taken), path.stat().st_size

    return of


@pytest.mark.compiled
@pytest.mark.parametrize(
    "words",
    [
        ["rolling", "roll_rate=2:4:300", "tilt=0.001deg:5deg:300:log"],
        ["rolling", "roll_rate=2:4:300", "tilt=0.001deg:5deg:300:log", "method=exact"],
        ["spinning", "precession_rate=1:9:250", "tilt=0.1deg:40deg:300"],
        ["circling", "tilt=5deg:60deg:60", "alpha=0.1:1:40", "duration=2s"],
        ["rolling", "roll_rate=2:4:100", "tilt=0.001deg:5deg:100:log", "contact=yes"],
        ["rolling", "roll_rate=0:0.1:100", "tilt=84.9deg:85.1deg:100"],
    ],
)
def test_the_bytes_on_disk_are_foretold(peak, tmp_path, words):
    """Within a factor of 1.5, and not less than a run takes."""
    spec = SweepSpec.from_words(words[0], words[1:])
    found = Forecast.measured(spec, 1)
    kept, written = peak(spec, tmp_path / "atlas.nc")
    assert (
        kept + written <= found.journal_bytes(spec) + found.file_bytes(spec) <= 1.5 * (kept + written) + 1e5
    )


def test_a_run_is_refused_only_where_it_does_not_fit(monkeypatch):
    """Between the bound and what a sample shows it is begun; below that it is refused, with the bytes that it needs."""
    bound = estimate.journal_bytes(MILLION, MILLION.size) + estimate.file_bytes(MILLION)
    usage = namedtuple("usage", "total used free")

    def with_free(size):
        monkeypatch.setattr(estimate.shutil, "disk_usage", lambda _: usage(10**12, 0, int(size)))
        check_room(Path("atlas.nc"), MILLION, MILLION.size)

    monkeypatch.setattr(forecast, "_keeping", lambda spec, rate: (0.0, 20.0, 30.0))
    with_free(1.01 * bound)
    with_free(51e6)
    with pytest.raises(RequestError, match="take about 50 MB, and 49 MB are free"):
        with_free(49e6)


def test_what_is_computed_already_needs_no_room_in_the_journal(monkeypatch):
    """A run that goes on needs room for the rest of the journal, and for the whole file."""
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(estimate.shutil, "disk_usage", lambda _: usage(10**12, 0, 31 * 10**6))
    monkeypatch.setattr(forecast, "_keeping", lambda spec, rate: (0.0, 20.0, 30.0))
    check_room(Path("atlas.nc"), MILLION, 0)
    with pytest.raises(RequestError, match="does not fit"):
        check_room(Path("atlas.nc"), MILLION, MILLION.size)
