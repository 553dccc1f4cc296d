"""An atlas file explains itself: its attributes contain what a reader needs to know."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.atlas.cf_metadata import edge_names
from sweep.request.spec import SweepSpec
from sweep.version import HOME

CHECKOUT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas in which one row has no boundary."""
    return sweep.run(SweepSpec(roll_rate="1:4:9", tilt="1deg,20deg", alpha=0.7, duration="20s", step="1ms"))


def test_the_criterion_is_stated_in_words(atlas):
    """The criterion is stated in words next to its code word; reclassifying changes both."""
    assert atlas.criterion == "departure:5deg"
    assert_facts(atlas.criterion_meaning, "unstable", "tilt", "5 deg")
    again = sweep.reclassify(atlas, "amplification:3")
    assert_facts(again.criterion_meaning, "unstable", "3", "perturbation")


def test_a_missing_boundary_is_explained(atlas):
    """Every variable of an edge explains its missing values; the boundary names the row status."""
    names = edge_names("roll_rate")
    assert np.isnan(atlas[names[0]].values).any()
    for name in names:
        assert atlas[name].comment.startswith("missing: ")
    assert "boundary_roll_rate_status" in atlas[names[0]].comment


def test_settings_and_fixed_parameters_have_units(atlas):
    """Settings and fixed parameters are global attributes, which survive selecting variables, with units."""
    assert (atlas.duration, atlas.duration_units) == (20.0, "s")
    assert (atlas.step, atlas.step_units) == (0.001, "s")
    assert (atlas.fall_tilt_units, atlas.tolerance_units) == ("rad", "rad")
    for name in ("tilt_rate", "precession_rate", "alpha", "radius", "gravity"):
        assert atlas.attrs[name] == atlas[name].item()
        assert atlas.attrs[f"{name}_units"] == atlas[name].units
    for name in ("roll_rate", "tilt"):
        assert name not in atlas.attrs
    automatic = sweep.run(SweepSpec(tilt="1deg"))
    assert (automatic.step, "step_units" in automatic.attrs) == ("auto", False)


def test_the_software_and_its_licence_are_those_of_the_package(atlas):
    """Version, home, license and citation agree with the files of the repository."""
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    assert f"{project['name']} {sweep.__version__}" in atlas.software
    # without a public home, no address may be promised
    homes = [*project.get("urls", {}).values()]
    assert HOME in homes if HOME else not homes
    assert HOME in atlas.software
    assert "pip install" not in atlas.software
    # the other license of the distribution belongs to a library of the explorer's page
    assert project["license"].removesuffix(" AND MIT") in atlas.license
    cited = (CHECKOUT / "CITATION.cff").read_text()
    title = re.search(r'title: "eulerdisk: (.*)"', cited)[1]
    assert title in atlas.citation
    assert re.search(r"name: (.*)", cited)[1] in atlas.citation


def test_the_signs_are_those_that_the_comments_say():
    """Positive tilt leans to the right of the way of a positive roll rate; positive precession turns left.

    The paths of the contact point and of the center of mass show where the disk goes and to which side it
    leans.
    """
    for roll_rate in [5.0, -5.0]:
        tilt, turn, radius = 0.2, 0.3, 0.5
        words = f"tilt={tilt} precession_rate={turn} roll_rate={roll_rate} radius={radius} duration=0.01 interval=1e-3"
        motion = sweep.simulate(sweep.TrajectorySpec.from_words(words.split()))
        x, y = motion["contact_x"].values, motion["contact_y"].values
        ahead = np.array([x[1] - x[0], y[1] - y[0]]) * np.sign(roll_rate)
        speed = np.hypot(*ahead) / 1e-3
        assert speed == pytest.approx(abs(roll_rate) * radius, rel=1e-3)
        aside = np.array([motion["centre_x"].values[0] - x[0], motion["centre_y"].values[0] - y[0]])
        # to the right: clockwise from the way ahead
        assert ahead[0] * aside[1] - ahead[1] * aside[0] < 0.0
        assert motion["heading"].values[1] > motion["heading"].values[0]
        table = sweep.run(SweepSpec(tilt="1deg")).coords
        assert_facts(table["tilt"].comment, "positive", "right", "roll_rate")
        assert_facts(table["precession_rate"].comment, "positive", "left", "counterclockwise")
        assert_facts(table["roll_rate"].comment, "positive", "forwards", "radius", "contact point")


def test_comments_say_what_a_missing_value_means():
    """A comment names exactly the endings of the cells without a value."""
    for spec in [
        sweep.SweepSpec(roll_rate="0:3:7", tilt="0deg:40deg:5", duration="3s"),
        sweep.SweepSpec(precession_rate="steady-slow", roll_rate="0.1:3:5", tilt="5deg:55deg:5"),
    ]:
        atlas = sweep.run(spec)
        words = dict(
            zip(atlas["ending"].flag_values.tolist(), atlas["ending"].flag_meanings.split(), strict=True)
        )
        for name in ("tilt_min", "tilt_max", "peak_tilt", "amplification", "fall_time", "nutation_period"):
            comment = atlas[name].comment
            told = comment[comment.index("missing where") :]
            for code in np.unique(atlas["ending"]).tolist():
                has_none = atlas[name].isnull().values[atlas["ending"].values == code]
                missing = words[code] in told
                if "ending is not " in told:
                    missing = not missing
                assert has_none.all() if missing else not has_none.any(), (name, words[code])
