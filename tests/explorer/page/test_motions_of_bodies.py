"""The page's motions of other bodies agree with `sweep.simulate`, including their potential."""

import math

import numpy as np
import pytest
from body_motion import in_space

import sweep
from sweep.explorer.about import sides
from sweep.explorer.view import View
from sweep.model.bodies.shape import body_of, has_poles
from sweep.model.lossy_bodies.tables import FACED
from sweep.motion.sampling import ending_of
from sweep.request.spec import SweepSpec

from .asking import ask
from .test_truth import BODIES

#: Compared quantities in space, and their stated errors.
STATED = {
    "axis": "orientation_error", "painted": "orientation_error", "turning": "rate_error", "centre": "path_error",
    "contact": "path_error", "force": "force_error",
}  # fmt: skip

#: The potential minus the energy at tilts, as drawn by the page.
EXCESS = """async ([start, body, tilts]) => {
    const { curveOfBody } = await import("eulerdisk/motion/body_potential");
    const curve = curveOfBody(start, body);
    return tilts.map((tilt) => curve(Math.atanh(Math.sin(tilt))).excess);
}"""


#: Time [ms] of each motion with its potential.
CLICKS = """async (requests) => {
    const { ServerSource } = await import("eulerdisk/server_source");
    const { Samples } = await import("eulerdisk/motion/samples");
    const source = new ServerSource();
    const times = [];
    for (const request of requests) {
        const began = performance.now();
        new Samples(await source.motion(request));
        times.push(performance.now() - began);
    }
    return times;
}"""


@pytest.fixture(
    params=[
        pytest.param(each, marks=pytest.mark.slow_lane if each == "ball" else pytest.mark.release)
        for each in BODIES
        if each != "disk"
    ]
)
def shown(request, served_with, opened):
    """Return a page with a map of a body, its view, and a function that requests the motion at shares of its sides."""
    words = BODIES[request.param]
    spec = SweepSpec.from_words(*((words[0], words[1:]) if "=" not in words[0] else ("rolling", words)))
    view = View.read({**sides(spec), "base": "", "words": {}}, spec)
    page = opened(served_with(*words).url)

    def asked(x, y, duration=None, losses=None):
        place = {
            side.name: float(side.at(np.array([2.0 * share - 1.0]))[0])
            for side, share in ((view.x, x), (view.y, y))
        }
        at = {"x": place[view.x.name], "y": place[view.y.name]}
        head, arrays = ask(
            page,
            "motion",
            view={**sides(spec), "base": "", "words": {}},
            **at,
            duration=duration,
            losses=losses or {},
        )
        start = {
            name: float(values[0])
            for name, values in view.starts(*(np.array([each]) for each in at.values())).items()
        }
        return head, arrays, start

    return page, view, asked


@pytest.mark.slow_lane
def test_a_motion_is_that_of_the_program(shown):
    """Samples agree within 1e-9 with `sweep.simulate`, which is itself compared with a rigid body in space.

    For diverging motions with a larger stated error, the limit is four times that. Only two seconds are
    compared, because
    near a separatrix the start's rounding grows beyond both stated errors.
    """
    _, view, asked = shown
    for x, y in ((0.2, 0.3), (0.7, 0.8), (0.45, 0.05)):
        head, arrays, start = asked(x, y, 2.0)
        words = {name: getattr(view.spec, name) for name in (*view.spec.constants, "body", "filling")}
        times, ended = arrays["time"], int(head["ended"])
        motion = sweep.simulate(**start | words, duration=times[-1] * (1.0 + 0.1 * ended), interval=times[1])
        assert head["ending"].startswith("followed for") != head["ended"]
        assert motion.sizes["elapsed_time"] == times.size
        other = {name: motion[name].values for name in motion.data_vars}
        for name in ("normal_force", "friction_across", "friction_along", "force_error"):
            other[name] = other[name] / start["gravity"]
        found, right = in_space(arrays), in_space(other)
        for name, error in STATED.items():
            off = np.linalg.norm(found[name] - right[name], axis=-1)
            size = max(1.0, float(np.linalg.norm(right[name], axis=-1).max()))
            assert (off <= np.maximum(1e-9 * size, 4.0 * other[error])).all(), (name, x, y, off.max())
        np.testing.assert_allclose(arrays["energy"], arrays["energy"][0], rtol=1e-8)


@pytest.mark.slow_lane
def test_a_motion_with_losses_is_that_of_the_program(shown):
    """Ending, last sample and losses by law agree with `sweep.simulate`; a ball has no losses and is refused."""
    _, view, asked = shown
    losses = {"rolling_friction": 2e-3, "contour_friction": 1e-3, "pivoting_friction": 1e-4}
    losses = {name: value * view.spec.radius for name, value in losses.items()}
    if has_poles(view.spec.body):
        assert asked(0.45, 0.6)[0]["losses"] == []
        with pytest.raises(Exception, match="rolls without losses"):
            asked(0.45, 0.6, 2.0, losses)
        return
    head, arrays, start = asked(0.45, 0.6, 2.0, losses)
    assert head["lossy"]
    assert ("air_law" in [each["name"] for each in head["losses"]]) == (view.spec.body in FACED)
    words = {name: getattr(view.spec, name) for name in (*view.spec.constants, "body", "filling")}
    motion = sweep.simulate(**start | words | losses, duration=2.0)
    assert head["ended"] == (ending_of(motion) != "horizon")
    assert arrays["time"][-1] == pytest.approx(float(motion["elapsed_time"][-1]), rel=1e-7)
    weight = start["gravity"]
    for name in arrays.keys() - {"time", "friction_needed"}:
        unit = weight if "force" in name or "friction" in name else 1.0
        unit = weight * start["radius"] if "loss" in name or name == "energy" else unit
        other = motion[name].values / unit
        size = max(1.0, float(np.abs(other).max()))
        assert abs(arrays[name][-1] - other[-1]) < 1e-6 * size, name
    # a longer motion has more samples, depending on the body's turns
    _, arrays, _ = asked(0.45, 0.6, 20.0, losses)
    count = sweep.simulate(**start | words | losses, duration=20.0).sizes["elapsed_time"]
    assert arrays["time"].size == pytest.approx(count, rel=0.01)


def test_the_potential_is_that_of_the_motion(shown):
    """Along a motion, the curve is below the energy by the kinetic energy of the tilt; it uses only the start."""
    page, view, asked = shown
    head, arrays, start = asked(0.45, 0.6)
    body = body_of(view.spec, {name: np.array([value]) for name, value in start.items()})
    core, shift, edge, square, axial, transverse, _ = (float(np.ravel(each)[0]) for each in body)
    names = ("core", "shift", "edge", "square", "axial", "transverse")
    assert [head["body"][name] for name in names] == pytest.approx(
        [core, shift, edge, square, axial, transverse]
    )
    tilt, rate = (
        arrays["tilt"][::20],
        arrays["tilt_rate"][::20] * math.sqrt(start["radius"] / start["gravity"]),
    )
    near = np.abs(tilt) < 1.5
    sine, cosine = np.sin(tilt[near]), np.cos(tilt[near])
    n = 1.0 / np.sqrt(cosine**2 + square * sine**2)
    inertia = transverse + (core + edge * n * cosine) ** 2 + (shift + edge * square * n * sine) ** 2
    shape = {name: head["body"][name] for name in ("name", *names)}
    found = page.evaluate(EXCESS, [start, shape, tilt[near].tolist()])
    np.testing.assert_allclose(found, -0.5 * inertia * rate[near] ** 2, atol=1e-6)


def test_a_click_is_answered_at_once(shown):
    """Motion and potential take less than 100 ms on an idle processor, and at most twice that in this test."""
    page, view, _ = shown
    place = {side: getattr(view, side).ends() for side in ("x", "y")}
    requests = [
        {"view": {**sides(view.spec), "base": "", "words": {}}, "duration": None, "losses": {}}
        | {side: float(low + share * (high - low)) for side, (low, high) in place.items()}
        for share in np.linspace(0.3, 0.7, 8)
    ]
    assert min(page.evaluate(CLICKS, requests)[1:]) < 200.0
