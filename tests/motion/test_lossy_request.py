"""The request for a motion with losses: which inputs make one, what it contains, and what is refused."""

import json
import math
import pickle
from dataclasses import asdict, replace

import pytest

from sweep import RequestError, TrajectorySpec
from sweep.motion.lossy_tables import LOSSY_MOTION, LOSSY_TRAJECTORY
from sweep.motion.request import LossyTrajectorySpec, MotionRequest


def test_any_word_of_losses_asks_for_the_disk_with_losses():
    """Even a zero selects the lossy model, in which nothing is then lost."""
    for words in [
        ["contour_friction=10um"],
        ["rolling_friction=0"],
        ["air_law=moffatt", "air_viscosity=1.8e-5", "mass=0.4kg"],
        ["contour_damping=1e-8", "mass=20g"],
    ]:
        spec = TrajectorySpec.from_words(["tilt=80deg", *words])
        assert isinstance(spec, LossyTrajectorySpec), words
        assert spec.kind.model.name == "lossy_disk", words
        assert (spec.flat_tilt, spec.duration) == (math.radians(89.9), 300.0), words


def test_mass_and_friction_are_words_of_every_motion():
    """They select no losses, so earlier requests with them stay the same."""
    assert type(TrajectorySpec.from_words(["mass=20g", "friction=0.3"])) is TrajectorySpec


def test_a_request_with_losses_is_a_value():
    """Its fields are its tables, its text contains them all, and it compares, changes and pickles."""
    spec = MotionRequest.read(
        tilt="80deg", contour_friction="15um", precession_rate="wobble", roll_rate="wobble"
    )
    assert set(asdict(spec)) == {*LOSSY_MOTION.inputs, *LOSSY_MOTION.words}
    assert MotionRequest.read(**json.loads(spec.canonical())) == spec
    heavier = replace(spec, mass=2.0)
    assert heavier != spec == pickle.loads(pickle.dumps(spec))
    assert (spec.mass, spec.friction, spec.contour_friction) == (
        "unknown",
        "unlimited",
        pytest.approx(1.5e-5),
    )


def test_every_quantity_is_complete():
    """Each has a long name, units or flags, a label, and only ASCII in its attributes."""
    for quantity in LOSSY_TRAJECTORY.values():
        assert quantity.long_name, quantity
        assert quantity.plot_label, quantity
        assert ("units" in quantity.attributes()) != ("flag_values" in quantity.attributes()), quantity
        assert all(str(value).isascii() for value in quantity.attributes().values()), quantity
        assert quantity.tolerance.reason, quantity


def test_a_refusal_says_what_is_allowed_what_was_given_and_what_to_do():
    """An impossible request is refused in one line."""
    for words, facts in [
        (["contour_friction=-1um"], ["contour_friction >= 0"]),
        (
            ["contour_friction=1um", "fall_tilt=80deg"],
            ["with losses is flat at flat_tilt", "Write flat_tilt"],
        ),
        (["flat_tilt=80deg"], ["without losses has fallen at fall_tilt", "Write fall_tilt"]),
        (["contour_friction=1um", "tilt=89.95deg"], ["|tilt| must be below flat_tilt", "larger flat_tilt"]),
        (["air_law=bildsten", "air_viscosity=1e-5", "mass=1"], ["needs the density of the air"]),
        (["air_law=moffatt", "air_viscosity=1e-5"], ["needs the mass", "mass=0.4kg"]),
        (["air_law=stokes"], ["none", "moffatt", "bildsten"]),
        (["contour_friction=1um,2um"], ["one number", "axis"]),
        (["contour_frictin=1um"], ["Did you mean contour_friction?"]),
        (["contour_friction=1m"], ["shorter than the radius"]),
    ]:
        with pytest.raises(RequestError) as refusal:
            TrajectorySpec.from_words(words)
        text = str(refusal.value)
        assert refusal.value.hint, (words, facts)
        assert "\n" not in text, (words, facts)
        for each in facts:
            assert each in text, (words, facts)
