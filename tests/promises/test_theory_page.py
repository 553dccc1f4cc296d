"""docs/theory.md: every displayed formula is evaluated as printed, at random motions.

The values of its symbols come from the kernels, from the theory of `sweep`, or from a referee of the tests,
and never from the formula itself.
"""

import math

import lagrange
import mpmath
import numpy as np
import pytest
import referee
from kernel_runner import flow
from latex_formula import Page
from scipy.integrate import solve_ivp
from thin_disk import contact_forces, friction_needed, vertical_momentum

import sweep
from kernels.disk import equations, error_estimate, steady
from kernels.disk.endings import BOUNDED
from kernels.reduction import turning
from sweep.model.disk import theory

PAGE = Page("theory.md")
FORMULAS, check = PAGE.formulas, PAGE.check


@pytest.fixture
def v(rng):
    """Return values of a random disk and its motion, in SI, by the names of their symbols."""
    angles = {"theta": rng.uniform(-1.2, 1.2), "psi": rng.uniform(-3.0, 3.0)}
    rates = {f"dot {name}": rng.normal() for name in ("theta", "psi", "varphi")}
    disk = {"alpha": rng.uniform(0.05, 1.0), "R": rng.uniform(0.3, 3.0)}
    return {**angles, **rates, **disk, "g": rng.uniform(1.0, 10.0), "m": rng.uniform(0.3, 3.0)}


def disk_of(v):
    """Return alpha, radius and gravity."""
    return v["alpha"], v["R"], v["g"]


def unit(v):
    """Return the kernels' unit of time [s]."""
    return math.sqrt(v["R"] / v["g"])


def scaled(v):
    """Return the kernels' state, six numbers."""
    state = (v[name] for name in ("theta", "dot theta", "dot psi", "dot varphi"))
    return equations.scaled_state(*state, unit(v))


def with_flow(v):
    """Add the six numbers and their derivatives in scaled time, from the kernels."""
    six = scaled(v)
    rates = flow(six, v["alpha"])
    derivatives = {f"d{name}/dtau": rate for name, rate in zip("SCTwos", rates, strict=True)}
    return {**v, **dict(zip("SCTwos", six, strict=True)), **derivatives}


def with_accelerations(v):
    """Add the second derivatives of the angles, from the kernels by the chain rule."""
    v = with_flow(v)
    turning = (v["do/dtau"] * v["C"] - v["o"] * v["dC/dtau"]) / v["C"] ** 2
    rolling = v["ds/dtau"] - v["do/dtau"] * v["T"] - v["o"] * v["dT/dtau"]
    found = {"theta": v["dw/dtau"], "psi": turning, "varphi": rolling}
    return {**v, **{f"ddot {name}": value / unit(v) ** 2 for name, value in found.items()}}


def with_path(v):
    """Add the velocity of the contact point, which satisfies the constraints of Lagrange's form."""
    q = np.array([0.0, 0.0, v["psi"], v["theta"], 0.0])
    W = lagrange.constraint_matrix(q, v["R"])
    x, y = np.linalg.solve(W[:, :2], -W[:, 4] * v["dot varphi"])
    return {**v, "dot x_C": x, "dot y_C": y}


def five(v):
    """Return coordinates and velocities of Lagrange's form."""
    q = np.array([0.3, -0.7, v["psi"], v["theta"], 0.4])
    return q, np.array([v[f"dot {name}"] for name in ("x_C", "y_C", "psi", "theta", "varphi")])


def with_steady_roll(v):
    """Replace the roll rate by the one that keeps the tilt constant."""
    return {**v, "dot varphi": steady.steady_roll_rate(v["theta"], v["dot psi"], *disk_of(v))}


# --- the page -------------------------------------------------------------------------------------------------------


def test_every_formula_is_tested():
    """Every displayed formula has a unique name, and a test in this file evaluates it."""
    assert PAGE.all_named
    assert PAGE.tested(__file__) == FORMULAS.keys()


def test_formulas_between_words_state_nothing():
    """Inline math is a symbol or an expression; equations and conditions are displayed on their own line."""
    assert len(PAGE.inline()) > 50
    assert PAGE.statements() == []


# --- angles and equations -------------------------------------------------------------------------------------------


def test_path_and_constraints(v):
    """The contact point moves as the constraint matrix of Lagrange's form says."""
    check("path", with_path(v))
    check("constraints", with_path(v))


def test_the_centre_and_the_kinetic_energy(v):
    """With the center's velocity from its position, the energy is Lagrange's, with or without slip."""
    rng = np.random.default_rng(0)
    v = {**v, "dot x_C": rng.normal(), "dot y_C": rng.normal()}

    def centre(t):
        moved = {name: v[name] + t * v[f"dot {name}"] for name in ("theta", "psi")}
        moved |= {"R": v["R"], "x_C": t * v["dot x_C"], "y_C": t * v["dot y_C"]}
        return np.array([line.value(moved) for line in FORMULAS["centre"]])

    h = 1e-4
    velocity = (8.0 * (centre(h) - centre(-h)) - centre(2.0 * h) + centre(-2.0 * h)) / (12.0 * h)
    q, rates = five(v)
    energy = 0.5 * rates @ lagrange.mass_matrix(q, v["alpha"], v["m"], v["R"]) @ rates
    places = {f"dot {name}_G": value for name, value in zip("xyz", velocity, strict=True)}
    check("kinetic", {**v, **places, "K": energy}, 1e-10)


def test_equations_in_angles(v):
    """They match the kernels and Lagrange's form."""
    v = with_accelerations(v)
    check("angles", v, 1e-11)
    q, rates = five(with_path(v))
    found, _ = lagrange.accelerations(q, rates, v["alpha"], v["m"], v["R"], v["g"])
    accelerations = dict(zip(("ddot psi", "ddot theta", "ddot varphi"), found[2:], strict=True))
    check("angles", {**v, **accelerations}, 1e-11)


def test_equations_of_the_code(v):
    """Scaled numbers, their derivatives and Newton's form match the kernels."""
    v = with_flow(v)
    check("scaled", v)
    check("slopes", v)
    check("newton", v)
    check("identities", v)


def test_forces_at_the_contact(v):
    """They match the kernels and the multipliers of Lagrange's form."""
    v = with_path(with_accelerations(v))
    weight = v["m"] * v["g"]
    forces = contact_forces(scaled(v), v["alpha"])
    needed = math.hypot(*forces[1:]) / forces[0]
    names = ("N", "lambda_1", "lambda_2")
    v |= {name: weight * value for name, value in zip(names, forces, strict=True)} | {"mu": needed}
    if forces[0] > 0.0:
        assert friction_needed(scaled(v), v["alpha"]) == pytest.approx(needed)
    check("contact", v, 1e-11)
    q, rates = five(v)
    _, multipliers = lagrange.accelerations(q, rates, v["alpha"], v["m"], v["R"], v["g"])
    assert (v["lambda_1"], v["lambda_2"]) == pytest.approx(multipliers, rel=1e-9)


# --- invariants -----------------------------------------------------------------------------------------------------


def test_energy(v):
    """Both forms match the referee's energy from velocities, and the kernels'."""
    v = with_flow(v)
    state = (v[name] for name in ("theta", "dot theta", "dot psi", "dot varphi"))
    check("energy", {**v, "E": v["m"] * referee.energy(tuple(state), *disk_of(v))})
    over = equations.energy(*(v[name] for name in "SCwos"), v["alpha"])
    check("energy", {**v, "E": over * v["m"] * v["g"] * v["R"]})


def test_chaplygins_system(v):
    """Derivatives by tilt are the kernels' time derivatives divided by the tilt rate."""
    v = with_flow(v)
    along = {f"d{name}/dtheta": v[f"d{name}/dtau"] / v["w"] for name in "so"}
    check("chaplygin", {**v, **along}, 1e-11)


def even_and_odd(alpha):
    """Return the two solutions of Legendre's equation as hypergeometric functions of u."""
    a = 0.25 - 0.5j * mpmath.sqrt(2.0 / (1.0 + alpha) - 0.25)
    b = mpmath.conj(a)
    half = mpmath.mpf(1) / 2
    return (
        lambda u: mpmath.re(mpmath.hyp2f1(a, b, half, u * u)),
        lambda u: mpmath.re(u * mpmath.hyp2f1(a + half, b + half, 3 * half, u * u)),
    )


def test_legendres_equation(v):
    """Hypergeometric functions solve it, match the rates of motions, and have the page's series."""
    u = math.sin(v["theta"])
    zero, alpha = np.zeros(1), np.array([v["alpha"]])
    for first, function in enumerate(even_and_odd(v["alpha"])):
        value, slope, curvature = (mpmath.diff(function, u, n) for n in range(3))
        # s of a motion with s = 1, or ds/du = 1, at upright.
        begin = (zero + 1.0, zero) if first == 0 else (zero, -(1.0 + alpha))
        s, _ = theory.carried_rates(zero, np.array([v["theta"]]), *begin, alpha)
        assert s[0] == pytest.approx(float(value), rel=1e-12)
        check("legendre", {**v, "u": u, "s": value, "ds/du": slope, "d2s/du2": curvature}, 1e-9)
        terms = mpmath.taylor(function, 0, 7)
        for n in range(first, 6, 2):
            check("series", {**v, "n": n, "a_n": terms[n], "a_n+2": terms[n + 2]}, 1e-9)


def test_the_balance_of_the_vertical_momentum(v):
    """Momentum and rate match the kernels, and the rate is the derivative along the kernels' flow."""
    six, h = np.array(scaled(v)), 1e-5
    ahead, behind = six + h * flow(six, v["alpha"]), six - h * flow(six, v["alpha"])
    size = v["m"] * v["R"] ** 2 / unit(v)
    momentum, rate = vertical_momentum(tuple(six), v["alpha"])
    check("balance", {**v, "H_3": size * momentum, "dH_3/dt": size / unit(v) * rate})
    change = (
        vertical_momentum(tuple(ahead), v["alpha"])[0] - vertical_momentum(tuple(behind), v["alpha"])[0]
    ) / (2.0 * h)
    check("balance", {**v, "H_3": size * momentum, "dH_3/dt": size / unit(v) * change}, 1e-7)


# --- steady motions -------------------------------------------------------------------------------------------------


def test_steady_motions(v):
    """The roll rate matches the kernels and keeps the tilt; so do both precession rates."""
    found = with_steady_roll(v)
    check("steady", found)
    assert with_accelerations({**found, "dot theta": 0.0})["ddot theta"] == pytest.approx(0.0, abs=1e-10)
    for rate in steady.steady_precession_rates(v["theta"], found["dot varphi"], *disk_of(v)):
        check("steady-precession", {**found, "dot psi": rate}, 1e-9)


def test_k(v):
    """It matches the kernels and the second derivative of the potential that accelerates the tilt."""
    v = with_flow(with_steady_roll({**v, "dot theta": 0.0}))
    size, second = equations.force.py_func(scaled(v), equations.inertia(v["alpha"]))
    assert size == pytest.approx(0.0, abs=1e-9)
    k = steady.stability_coefficient(v["theta"], v["dot psi"], v["dot varphi"], *disk_of(v))
    check("k", {**v, "k": k}, 1e-10)
    check("k-potential", {**v, "k": k, "V''": second}, 1e-9)


def test_slopes_of_the_potential(v):
    """They match the kernels in any state."""
    v = with_flow(v)
    size, second = equations.force.py_func(scaled(v), equations.inertia(v["alpha"]))
    first = -(1.0 + 0.5 * v["alpha"]) * v["dw/dtau"]
    assert abs(first) == pytest.approx(size)
    v |= {"V'": first, "V''": second, "o'": v["do/dtau"] / v["w"]}
    check("potential-slopes", v, 1e-10, defines=("q", "q'"))


def test_critical_rates(v):
    """Upright k matches the kernels and vanishes at the critical rates, as printed for disk and hoop."""
    upright = {**v, "theta": 0.0}
    alpha, radius, gravity = disk_of(v)
    k = steady.stability_coefficient(0.0, v["dot psi"], v["dot varphi"], alpha, radius, gravity)
    roll = math.sqrt(steady.critical_roll_rate_squared(alpha, radius, gravity))
    spin = math.sqrt(steady.critical_precession_rate_squared(alpha, radius, gravity))
    check("critical", {**upright, "k": k, "dot varphi_c": roll, "dot psi_c": spin})
    for rates in ((0.0, roll), (spin, 0.0)):
        assert steady.stability_coefficient(0.0, *rates, *disk_of(v)) == pytest.approx(
            0.0, abs=1e-12 * gravity / radius
        )
    of_two = dict(v)
    for name, of in (("disk", 0.5), ("hoop", 1.0)):
        of_two[f"dot varphi_{name}"] = math.sqrt(steady.critical_roll_rate_squared(of, radius, gravity))
        of_two[f"dot psi_{name}"] = math.sqrt(steady.critical_precession_rate_squared(of, radius, gravity))
    check("critical-of-two", of_two)


def test_critical_circling(v):
    """Both rates of the kernels solve the quadratic equation, and k vanishes there."""
    for tilt in (-0.3, 0.02, 0.2):
        v = {**v, "theta": tilt}
        for rate in steady.marginal_precession_rates(tilt, 0.0, *disk_of(v)):
            check("marginal", {**v, "P": rate**2}, 1e-10 * v["g"] ** 2, defines=("a", "b", "A", "B", "D"))
            roll = steady.steady_roll_rate(tilt, rate, *disk_of(v))
            k = steady.stability_coefficient(tilt, rate, roll, *disk_of(v))
            assert k == pytest.approx(0.0, abs=1e-9 * v["g"] / v["R"]), tilt


# --- criteria -------------------------------------------------------------------------------------------------------


def carried(start, tilt, rates, alpha):
    """Return s and o at a tilt, integrated by SciPy from another tilt."""

    def slopes(at, rates):
        return [-rates[1] / (1.0 + alpha), rates[1] * math.tan(at) - 2.0 * rates[0]]

    return solve_ivp(slopes, (start, tilt), rates, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


@pytest.mark.parametrize(("axis", "word"), [("roll_rate", "varphi"), ("precession_rate", "psi")])
def test_the_rate_that_turns_a_start_back(v, axis, word):
    """At the page's rate the referee finds the requested extreme tilt; theory predicts the same rate."""
    start, tilt, push = 0.05, 0.3, 0.2
    at_start = (1.0, 0.0) if axis == "roll_rate" else (math.sin(start), math.cos(start))
    f, h = carried(start, tilt, at_start, v["alpha"])
    rates = {"f": f, "h": h, "f_0": at_start[0], "h_0": at_start[1]}
    row = {
        "tilt": start,
        "tilt_rate": push / unit(v),
        "alpha": v["alpha"],
        "radius": v["R"],
        "gravity": v["g"],
    }
    columns = {name: np.array([value]) for name, value in row.items()}
    predicted = theory._turning_rate(columns, np.array([tilt]), axis)[0]
    known = {**v, **rates, "w_0": push, "C_0": math.cos(start), "C": math.cos(tilt)}
    check("holding", {**known, "p": predicted * unit(v)}, 1e-9)
    extremes = referee.extremes(referee.starts(**row, **{axis: predicted}))
    assert extremes.greatest[0] == pytest.approx(tilt, abs=1e-8)


def test_where_a_departure_puts_the_boundary(v):
    """The squared rate that stops an undisturbed disk at a tilt deviates from the series in fourth order."""
    row = {"tilt": 0.0, "tilt_rate": 0.0, "alpha": v["alpha"], "radius": 1.0, "gravity": 1.0}
    columns = {name: np.array([value]) for name, value in row.items()}
    shares, reach = {}, 0.02
    for name, axis, critical in (
        ("r_roll", "roll_rate", steady.critical_roll_rate_squared),
        ("r_spin", "precession_rate", steady.critical_precession_rate_squared),
    ):
        rate = theory._turning_rate(columns, np.array([reach]), axis)[0]
        shares[name] = rate**2 / critical(v["alpha"], 1.0, 1.0)
    check("departure", {**v, "Theta": reach, **shares}, reach**4)


def amplified(v, rates, tilt=0.0, push=0.0, about=0.0):
    """Return the largest distance from a tilt relative to the disturbance, by the referee."""
    row = {"tilt": tilt, "tilt_rate": push, "alpha": v["alpha"], "radius": v["R"], "gravity": v["g"]}
    found = referee.extremes(referee.starts(**row, **rates))
    reach = max(abs(found.greatest[0] - about), abs(found.least[0] - about))
    rate = math.sqrt(steady.fall_rate_squared(*disk_of(v)))
    return reach / math.hypot(tilt - about, push / rate)


@pytest.mark.slow_lane
def test_where_an_amplification_puts_the_boundary(v):
    """The referee's amplification of a small disturbance is the one whose boundary is there."""
    omega = math.sqrt(steady.fall_rate_squared(*disk_of(v)))
    check("fall-rate", {**v, "Omega": omega})
    roll = steady.critical_roll_rate_squared(*disk_of(v))
    spin = steady.critical_precession_rate_squared(*disk_of(v))
    ratio, small = 1.3, 1e-5
    tilt, turning = 0.1, 1.5 * math.sqrt(v["g"] / v["R"])
    circling = {"precession_rate": turning, "roll_rate": steady.steady_roll_rate(tilt, turning, *disk_of(v))}
    found = {
        "r_push": amplified(v, {"roll_rate": math.sqrt(ratio * roll)}, push=small * omega),
        "r_roll": amplified(v, {"roll_rate": math.sqrt(ratio * roll)}, tilt=small),
        "r_spin": amplified(v, {"precession_rate": math.sqrt(ratio * spin)}, tilt=small),
        "k_circling": amplified(v, circling, tilt=tilt, push=small * omega, about=tilt),
    }
    values = dict.fromkeys(("r_push", "r_roll", "r_spin"), ratio)
    values["k_circling"] = steady.stability_coefficient(tilt, *circling.values(), *disk_of(v))
    for line in FORMULAS["amplification"]:
        known = {**v, **values, "Omega": omega, "A": found[line.first]}
        assert line.error(known) <= 2e-4, line.text


# --- the reduction, and errors --------------------------------------------------------------------------------------


def test_the_reduced_motion(v):
    """The energy is that of a particle in the potential; rates in the stretched tilt follow from time."""
    v = with_flow(v)
    over = equations.energy(*(v[name] for name in "SCwos"), v["alpha"])
    check("reduced", {**v, "E": over * v["m"] * v["g"] * v["R"]}, defines=("V",))
    to_y = v["C"] / v["w"]
    v["y"] = turning.stretch.py_func(math.asin(v["S"]))
    v |= {"p": v["o"] * v["C"], "ds/dy": v["ds/dtau"] * to_y}
    v["dp/dy"] = (v["do/dtau"] * v["C"] + v["o"] * v["dC/dtau"]) * to_y
    check("stretched", v, 1e-11)


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("roll_rate", [2.0, 4.0])
def test_the_period(roll_rate):
    """The integral between a cell's turning points is the period found by the exact reduction."""
    cell = sweep.run("rolling", roll_rate=roll_rate, tilt=0.05, tilt_rate=0.3, method="exact")
    alpha, radius, gravity = (float(cell[name]) for name in ("alpha", "radius", "gravity"))
    S, C, _, w, o, s = equations.scaled_state(0.05, 0.3, 0.0, roll_rate, math.sqrt(radius / gravity))
    energy = equations.energy(S, C, w, o, s, alpha)

    def speed(values):
        there = values["theta"]
        start = [np.array([each]) for each in (0.05, there, s, o, alpha)]
        s_there, o_there = (float(each[0]) for each in theory.carried_rates(*start))
        left = energy - equations.energy(math.sin(there), math.cos(there), 0.0, o_there, s_there, alpha)
        # Rounding near a turning point, where the square root would otherwise fail.
        return math.sqrt(max(left, 1e-17) / (0.5 * (1.0 + 0.5 * alpha)))

    ends = {"theta_1": float(cell.tilt_min), "theta_2": float(cell.tilt_max)}
    values = {"w": speed, "R": radius, "g": gravity, "P": float(cell.nutation_period), **ends}
    check("period", values, 1e-6)


def test_the_drift(v):
    """It is the sum by which the kernels decide whether a step is short enough."""
    rng = np.random.default_rng(1)
    S, C, _, w, o, s = start = scaled(v)
    state = tuple(np.array(start) + 1e-3 * rng.normal(size=6))
    alpha = v["alpha"]
    whole = equations.energy(S, C, w, o, s, alpha)
    found = error_estimate.drift.py_func(
        state, (S, C, w, o, s), whole, alpha, equations.inertia(alpha), 10.0
    )[0]
    size, (S_end, C_end, T_end, *rates) = v["m"] * v["g"] * v["R"], state
    change = equations.energy_change(S_end, C_end, *rates, S, C, w, o, s, alpha)
    energies = {"E": size * (whole + change), "E_0": size * whole}
    check("drift", {**v, "S": S_end, "C": C_end, "T": T_end, **energies, "D": found})


def stated(six, alpha, uncertain, monkeypatch):
    """Return the kernels' stated error of a turning point."""
    # Called as Python, because functions that only kernels call have no Python entry point.
    monkeypatch.setattr(error_estimate, "force", equations.force.py_func)
    estimate = error_estimate.estimated_error.py_func
    return estimate(BOUNDED, six, (0.0, 0.0, 0.0, 0.0), uncertain, equations.inertia(alpha))[1]


def test_the_stated_error(v, monkeypatch):
    """Without a hill it matches the kernels; near one it is infinite where the page's condition holds."""
    v = with_flow({**v, "dot theta": 1e-4 * v["dot theta"]})
    size, second = equations.force.py_func(scaled(v), equations.inertia(v["alpha"]))
    slope = -(1.0 + 0.5 * v["alpha"]) * v["dw/dtau"]
    (condition,) = FORMULAS["hidden"]
    edge = slope**2 / (8.0 * abs(second))
    for share in (1e-6, 0.99, 1.01, 100.0):
        known = {**v, "U": share * edge, "V'": slope, "V''": second}
        found = stated(scaled(v), v["alpha"], share * edge, monkeypatch)
        assert condition.holds(known) == math.isinf(found)
        if math.isfinite(found):
            check("error", {**known, "Delta": found})
    assert size == pytest.approx(abs(slope))


def test_a_hill_hides_a_turning_point(v, monkeypatch):
    """Slow disks have a hill at upright: there the page's condition holds on only one side of its edge."""
    slow = {**v, "theta": 0.01, "dot theta": 0.0, "dot psi": 0.0, "dot varphi": 0.15 / unit(v)}
    slow = with_flow(slow)
    _, second = equations.force.py_func(scaled(slow), equations.inertia(v["alpha"]))
    assert second < 0.0
    slope = -(1.0 + 0.5 * v["alpha"]) * slow["dw/dtau"]
    (condition,) = FORMULAS["hidden"]
    for share, hidden in ((0.99, False), (1.01, True)):
        uncertain = share * slope**2 / (-8.0 * second)
        assert condition.holds({**slow, "U": uncertain, "V'": slope, "V''": second}) == hidden
        assert math.isinf(stated(scaled(slow), v["alpha"], uncertain, monkeypatch)) == hidden
