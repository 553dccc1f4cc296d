"""Requests for random starts: the inputs, the resulting spec, and what cannot be combined."""

import pickle
import re

import numpy as np
import pytest
from messages import refused

from sweep.engine.grid import Span, starts_at, starts_of, whole
from sweep.request.spec import SweepSpec

RANDOM = ["roll_rate=uniform:2:4", "tilt=normal:1deg:0.2deg", "samples=1e3", "seed=7"]


@pytest.fixture
def spec():
    """Return a spec of 1000 random starts."""
    return SweepSpec.from_words("rolling", RANDOM)


def test_a_list_has_one_dimension(spec):
    """Its dimension counts the starts; the other parameters keep their numbers."""
    assert spec.axes == ("start",)
    assert spec.shape == (1000,)
    assert spec.is_list
    assert spec.listed == ("tilt", "roll_rate")
    assert spec.fixed == ("tilt_rate", "precession_rate", "alpha", "radius", "gravity")
    assert spec.start.array().tolist() == list(range(1000))


def test_a_list_survives_all_its_spellings(spec, tmp_path):
    """Canonical text, TOML, pickle and replace give the same spec, as short texts instead of values."""
    assert SweepSpec.from_canonical(spec.canonical()) == spec
    assert pickle.loads(pickle.dumps(spec)) == spec
    (tmp_path / "list.toml").write_text(spec.to_toml())
    assert SweepSpec.from_toml(tmp_path / "list.toml") == spec
    assert spec.replace(title="x").replace(title="") == spec
    assert len(spec.replace(samples="1e6").canonical()) < 600
    assert spec != spec.replace(seed=8)


def test_starts_are_drawn(spec):
    """Every start has its own tilt and roll rate; all other parameters are constant."""
    starts = whole(spec)
    assert 2.0 <= starts["roll_rate"].min() < 2.01
    assert 3.99 < starts["roll_rate"].max() <= 4.0
    assert np.degrees(starts["tilt"].mean()) == pytest.approx(1.0, abs=0.03)
    assert np.degrees(starts["tilt"].std()) == pytest.approx(0.2, abs=0.02)
    assert not np.ptp(starts["alpha"])
    assert abs(np.corrcoef(starts["tilt"], starts["roll_rate"])[0, 1]) < 0.13


def test_a_start_depends_on_its_number_alone(spec):
    """More starts, other parameters, parts and single cells change none of its bits."""
    starts = whole(spec)
    more = starts_of(spec.replace(samples=5000), Span(0, 1000))
    other = whole(spec.replace(alpha="uniform:0.5:1"))
    some = np.array([3, 999, 17])
    part = whole(spec.replace(start=[3, 17, 999]))
    for name in spec.listed:
        assert np.array_equal(more[name], starts[name])
        assert np.array_equal(other[name], starts[name])
        assert np.array_equal(starts_at(spec, some)[name], starts[name][some])
        assert np.array_equal(part[name], starts[name][np.sort(some)])
    assert not np.array_equal(whole(spec.replace(seed=8))["tilt"], starts["tilt"])


def test_a_part_of_a_list(spec):
    """It keeps its start numbers, also in its text."""
    part = spec.replace(start=[3, 17, 999])
    assert part.shape == (3,)
    assert SweepSpec.from_canonical(part.canonical()) == part
    assert part.replace(title="x").start.array().tolist() == [3, 17, 999]
    assert spec.replace(start="0:999:1000") == spec
    assert spec.replace(start="0:999") == spec
    assert spec.replace(start="3:12") == spec.replace(start="3:12:10")


def test_spellings_of_samples(spec):
    """A whole number is accepted in any notation."""
    for count in ["1e3", "1000", 1000, 1000.0, " 1000 "]:
        assert spec.replace(samples=count) == spec


def test_what_does_not_go_together():
    """The message names the wrong input and what to write."""
    for words, where, facts in [
        (["samples=10"], "samples", ["distribution"]),
        (RANDOM[:2], "tilt", ["tilt", "samples=1e6"]),
        (RANDOM[:1] + RANDOM[2:], "preset rolling: tilt", ["tilt", "distribution"]),
        ([*RANDOM, "alpha=0.5,1"], "alpha", ["samples", "axes"]),
        ([*RANDOM, "alpha=0.5,"], "alpha", ["samples", "axes"]),
        ([*RANDOM[:3], "seed=-1"], "seed", ["0", "18446744073709551615", "-1"]),
        ([*RANDOM[:3], "seed=1.5"], "seed", ["0", "18446744073709551615", "1.5"]),
        ([*RANDOM[:2], "samples=0"], "samples", ["1", "2147483647", "0"]),
        ([*RANDOM[:2], "samples=1e10"], "samples", ["1", "2147483647", "1e10"]),
        ([*RANDOM[:2], "samples=ten"], "samples", ["1", "2147483647", "ten"]),
        ([*RANDOM[:2], "samples=nan"], "samples", ["1", "2147483647", "nan"]),
        ([*RANDOM, "boundary=refined"], "boundary", ["grid"]),
        ([*RANDOM, "start=990:1000:11"], "start", ["0 to 999"]),
        ([*RANDOM, "start=0.5,1"], "start", ["whole numbers"]),
        ([*RANDOM, "start=0:10:4"], "start", ["whole numbers"]),
        ([*RANDOM, "start=9:0"], "start", ["whole numbers"]),
        ([*RANDOM, "start=0:9.5"], "start", ["whole numbers"]),
        (["seed=3"], "seed", ["seed", "random"]),
        (["start=3"], "start", ["start"]),
        (["duration=uniform:1:2"], "duration=uniform:1:2", ["start:stop:count[:log]"]),
        (["sample=10"], "sample", ["samples?"]),
    ]:
        with refused(*facts) as caught:
            SweepSpec.from_words("rolling", words)
        assert caught.value.where == where


def test_rates_that_a_cell_computes_follow_from_its_start():
    """The roll rate of each random tilt and precession rate keeps the tilt."""
    spec = SweepSpec.from_words(
        "circling", ["precession_rate=uniform:1:6", "tilt=uniform:1deg:20deg", "samples=50"]
    )
    assert spec.computed == ("roll_rate",)
    starts = whole(spec)
    assert np.isfinite(starts["roll_rate"]).all()
    assert np.ptp(starts["roll_rate"]) > 0.0


def test_a_normal_precession_rate_around_zero_is_no_precession_of_zero():
    """roll_rate=steady needs precession, and every start has some."""
    words = ["precession_rate=normal:0:1", "tilt=5deg", "samples=50"]
    assert SweepSpec.from_words("circling", words).size == 50


def test_scaled_distributions():
    """In units of sqrt(g/R) or as a speed, they give the rates of the requested disk."""
    words = ["scaled_roll_rate=uniform:0.5:0.8", "tilt=1deg", "samples=50", "radius=12mm"]
    spec = SweepSpec.from_words("rolling", words)
    rate = (9.81 / 0.012) ** 0.5
    assert spec.roll_rate.ends().tolist() == pytest.approx([0.5 * rate, 0.8 * rate])
    fast = SweepSpec.from_words("rolling", ["speed=normal:15cm/s:1cm/s", *words[1:]])
    assert (fast.roll_rate.first, fast.roll_rate.second) == pytest.approx((0.15 / 0.012, 0.01 / 0.012))
    for radius in ("radius=uniform:1cm:2cm", "radius=normal:1cm:1mm"):
        with refused("radius", "rad s-1") as caught:
            SweepSpec.from_words("rolling", [*words[:-1], radius])
        assert re.search(r"roll_rate=uniform:[\d.]+:[\d.]+", caught.value.hint)
