"""What a model tells the engine, and the defaults of a model that defines only what it must."""

import numpy as np
import pytest

from sweep.engine.compute import reach_and_scale
from sweep.engine.grid import whole
from sweep.model.description import Model
from sweep.model.disk.model import DISK
from sweep.request.spec import SweepSpec


class Plain(type(DISK)):
    """The disk without everything that a model may omit."""

    name = "plain"
    exact = None
    disturbed_motion, check, complete = Model.disturbed_motion, Model.check, Model.complete
    cell_variables, kernels, measure_more = Model.cell_variables, Model.kernels, Model.measure_more
    lines, line_label, joined_edges, unit_of_square = (
        Model.lines,
        Model.line_label,
        Model.joined_edges,
        Model.unit_of_square,
    )
    lost_in_words, linear_prediction, may_be_lost = (
        Model.lost_in_words,
        Model.linear_prediction,
        Model.may_be_lost,
    )


def test_what_a_model_need_not_say():
    """Without theory, exact reference or its own inputs it gets empty defaults; its starts are complete."""
    plain, spec = Plain(), SweepSpec(tilt="0.1,0.2", roll_rate="1:3:4")
    starts = whole(spec)
    assert plain.complete(spec, starts) is starts
    assert plain.cell_variables(spec) == DISK.variables
    assert plain.kernels(spec) == (DISK.integrate,)
    assert (plain.measure_more(spec, starts, {}), plain.lines(spec, "roll_rate", starts)) == ({}, {})
    assert (plain.line_label(spec, "roll_rate"), plain.joined_edges(spec)) == ("", None)
    assert plain.unit_of_square(spec, "roll_rate") is None
    assert list(plain.linear_prediction(spec, {}, {})) == []
    assert plain.lost_in_words(spec, {"ending": DISK.endings.code("fell")}) == DISK.endings.of(4).reason
    assert plain.disturbed_motion(spec, {})
    assert not plain.may_be_lost(spec, {}, np.full(3, 1e9)).any()
    plain.check({})


def test_controls_are_the_axes_with_a_boundary():
    """Boundaries are sought only along control parameters, in the order of the axes."""
    assert DISK.controls(("roll_rate", "tilt", "precession_rate")) == ["roll_rate", "precession_rate"]
    assert DISK.controls(("tilt", "alpha", "tilt_rate")) == []


def test_a_map_has_the_first_control_upward():
    """The vertical axis of a map is the first control parameter, or the first axis if there is none."""
    for axes, expected in [
        (("tilt", "roll_rate"), "roll_rate"),
        (("precession_rate", "roll_rate"), "precession_rate"),
        (("alpha", "tilt"), "alpha"),
    ]:
        assert DISK.upward(axes) == expected, axes


def test_reach_is_the_larger_distance_from_the_undisturbed_motion():
    """Either extreme may be farther away. Without extremes the reach is NaN."""
    spec = SweepSpec(tilt="0.1,0.2,0.3")
    measured = {"tilt_min": np.array([-0.3, 0.1, np.nan]), "tilt_max": np.array([0.2, 0.4, np.nan])}
    reach, scale = reach_and_scale(spec, whole(spec), measured)
    assert reach.tolist()[:2] == [0.3, 0.4]
    assert np.isnan(reach[2])
    assert scale.tolist() == [0.1, 0.2, 0.3]


def test_a_model_has_to_say_what_is_disturbed():
    """Headline, undisturbed motion and perturbation have no default; a model needs all three."""
    assert Model.__abstractmethods__ == {"subject", "undisturbed", "perturbation"}
    with pytest.raises(TypeError):
        Model()
