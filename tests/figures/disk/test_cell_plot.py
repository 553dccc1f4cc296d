"""The figure of a cell: every ending has one or a reason why not."""

import math
import re

import numpy as np
import pytest
from messages import assert_facts, refused, with_facts

import sweep
from sweep.checks.explain import explain
from sweep.figures.disk import cell_plot
from sweep.model.disk.tables import VARIABLES

#: Cells by their ending.
CELLS = {
    "bounded": sweep.SweepSpec(tilt="1deg", roll_rate=2.4),
    "steady": sweep.SweepSpec(tilt=0.0, roll_rate=3.0, duration="20s"),
    "fell": sweep.SweepSpec(tilt="40deg", roll_rate=1.0),
    "horizon": sweep.SweepSpec(tilt="1deg", roll_rate=2.4, duration="0.5s"),
    "unresolved": sweep.SweepSpec(tilt="1deg", roll_rate=1e200),
    "invalid": sweep.SweepSpec(tilt="5deg", precession_rate=[0.0, 1.0], roll_rate="steady").replace(
        precession_rate=[-1.0, 0.0, 1.0]
    ),
    "not_computed": sweep.SweepSpec(tilt="5deg", roll_rate=4.0),
}
WITHOUT = {"unresolved": "resolved", "invalid": "roll_rate="}


def explained(ending):
    """Return the explanation of a cell with this ending."""
    atlas = sweep.run(CELLS[ending])
    if ending == "not_computed":
        # as `info --partial` writes a cell whose block is missing
        for name in atlas.data_vars:
            atlas[name].values[...] = 0 if atlas[name].dtype.kind == "i" else np.nan
    found = explain(atlas, {"precession_rate": 0.0} if ending == "invalid" else {})
    assert f"ending      {ending.replace('_', ' ')}" in found.text
    return found


def test_every_ending_is_known():
    """The cells above cover all endings, and no explanation contains "nan"."""
    for ending in CELLS:
        assert set(CELLS) == set(VARIABLES["ending"].flags.values())
        found = explained(ending)
        assert " nan " not in found.text
        assert found.repeated


def test_a_cell_that_was_not_computed_has_nothing_to_repeat():
    """For a cell that was not computed, nothing differs, and the exact result is given."""
    text = explained("not_computed").text
    assert_facts(text, "not been computed")
    assert "DIFFER" not in text
    assert re.search(r"^exact .*: bounded", text, re.MULTILINE)


@pytest.mark.slow_lane
def test_the_figure_follows_the_motion_for_some_periods():
    """The curve spans three periods, the time to the fall, or the duration."""
    for ending in [ending for ending in CELLS if ending not in WITHOUT]:
        found = explained(ending)
        left, right = cell_plot.figure(found).axes
        time, tilt = left.get_lines()[0].get_data()
        assert np.all(np.diff(time) > 0.0)
        assert tilt[0] == pytest.approx(math.degrees(found.start["tilt"]))
        longest = {"fell": found.stored["fall_time"], "steady": 20.0, "horizon": 0.5}
        assert time[-1] == pytest.approx(longest.get(ending, 3.0 * found.exact["nutation_period"]))
        assert np.isfinite(right.get_lines()[0].get_data()).all()
        labels = [text.get_text() for text in left.get_legend().get_texts()]
        assert bool(with_facts(labels, "extremes")) == (ending != "not_computed")


def test_lines_stand_at_the_stored_extremes_and_at_the_limit():
    """Lines mark the stored extremes and both limits around the steady tilt, unless the curve would look flat."""
    found = explain(sweep.run(sweep.SweepSpec(tilt="1deg", roll_rate=2.4, criterion="departure:2deg")), {})
    lines = {line.get_label(): line for line in cell_plot.figure(found).axes[0].get_lines()}
    levels = sorted(line.get_ydata()[0] for line in cell_plot.figure(found).axes[0].get_lines()[1:])
    extremes = [math.degrees(found.stored[name]) for name in ("tilt_min", "tilt_max")]
    assert levels == pytest.approx(sorted([*extremes, -2.0, 2.0]), rel=1e-12)
    assert lines["limit of the criterion"].get_color() != lines["extremes in the atlas"].get_color()
    far = explain(sweep.run(sweep.SweepSpec(tilt="1deg", roll_rate=2.4, criterion="departure:60deg")), {})
    assert len(cell_plot.figure(far).axes[0].get_lines()) == 3


def test_the_path_is_that_of_the_motion():
    """A steadily circling disk has a circular path of radius R |roll rate / precession rate|."""
    spec = sweep.SweepSpec(tilt="10deg", precession_rate=0.5, roll_rate=-4.68510, duration="13s")
    found = explain(sweep.run(spec), {})
    x, y = cell_plot.figure(found).axes[1].get_lines()[0].get_data()
    # x^2 + y^2 = 2 a x + 2 b y + c
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones_like(x)]), x**2 + y**2)
    assert math.sqrt(c + a**2 + b**2) == pytest.approx(0.5 * 4.6851 / 0.5, rel=1e-4)


def test_a_cell_without_a_motion_has_no_figure():
    """An impossible start, or one without a motion, is refused with the reason."""
    for ending in WITHOUT:
        with refused(WITHOUT[ending]):
            cell_plot.figure(explained(ending))


def test_the_command_tells_what_it_can(tmp_path, command):
    """Without a motion to draw, the text is printed anyway; the status is 2, and there is no figure."""
    sweep.run_to_file(CELLS["invalid"], tmp_path / "a.nc")
    status, out, err = command("explain a.nc precession_rate=0 --plot cell.png")
    assert status == 2
    assert_facts(out, "undecided")
    assert_facts(err, "roll_rate=", "finite")
    assert "finite" in err
    assert "roll_rate=" in err
    assert not (tmp_path / "cell.png").exists()


def test_a_folder_that_is_not_there_is_told_first(tmp_path, command):
    """An output folder that does not exist is reported before anything is computed."""
    sweep.run_to_file(CELLS["bounded"], tmp_path / "a.nc")
    status, out, err = command("explain a.nc --plot missing/cell.png")
    assert (status, out) == (2, "")
    assert "missing/cell.png: " in err
    assert_facts(err, "mkdir -p missing")
