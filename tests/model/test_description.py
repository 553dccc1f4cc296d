"""What a model tells the engine, and what a model has that says no more than it must."""

import numpy as np
import pytest

from sweep.engine.compute import reach_and_scale
from sweep.engine.grid import whole
from sweep.model.description import Model
from sweep.model.disk.model import DISK
from sweep.request.spec import SweepSpec


class Plain(type(DISK)):
    """The disk, except for all that a model need not say."""

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
    """Without theory, exact reference and words of its own a model has none, and its starts are complete."""
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
    """A boundary is sought along control parameters only, in the order of the axes."""
    assert DISK.controls(("roll_rate", "tilt", "precession_rate")) == ["roll_rate", "precession_rate"]
    assert DISK.controls(("tilt", "alpha", "tilt_rate")) == []


def test_a_map_has_the_first_control_upward():
    """Of two axes the rate along which a boundary is sought goes up, wherever it stands; of two others the first."""
    for axes, expected in [
        (("tilt", "roll_rate"), "roll_rate"),
        (("precession_rate", "roll_rate"), "precession_rate"),
        (("alpha", "tilt"), "alpha"),
    ]:
        assert DISK.upward(axes) == expected, axes


def test_reach_is_the_larger_distance_from_the_undisturbed_motion():
    """Either extreme may be the farther one; without extremes there is no reach."""
    spec = SweepSpec(tilt="0.1,0.2,0.3")
    measured = {"tilt_min": np.array([-0.3, 0.1, np.nan]), "tilt_max": np.array([0.2, 0.4, np.nan])}
    reach, scale = reach_and_scale(spec, whole(spec), measured)
    assert reach.tolist()[:2] == [0.3, 0.4]
    assert np.isnan(reach[2])
    assert scale.tolist() == [0.1, 0.2, 0.3]


def test_a_model_has_to_say_what_is_disturbed():
    """Title, undisturbed motion and perturbation have no default: a model without them cannot be made."""
    assert Model.__abstractmethods__ == {"headline", "undisturbed", "perturbation"}
    with pytest.raises(TypeError):
        Model()
