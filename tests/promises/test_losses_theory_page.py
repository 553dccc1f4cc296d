"""docs/losses-theory.md: every displayed formula is evaluated as printed, at random motions with losses.

The values of its symbols come from the referee of the lossy disk, which shares no code with the kernels, and
from quadrature, never from the formula itself.
"""

import itertools
import math

import lossy_motion
import lossy_referee as lossy
import lossy_wobble
import mpmath
import numpy as np
import pytest
import referee
from latex_formula import Page

from kernels.disk import steady
from kernels.lossy_disk import endings

PAGE = Page("losses-theory.md")
FORMULAS, check = PAGE.formulas, PAGE.check

#: Names of the coefficients in the referee's order, and of the laws in the order of the page's lines.
COEFFICIENTS = ("alpha", "c_r", "c_p", "c_c", "k", "q_M", "q_B")
LAWS = ("contour", "damping", "moffatt", "bildsten", "rolling")


@pytest.fixture
def v(rng):
    """Return values of a random disk with all losses, its scaled motion, and the referee's accelerations."""
    given = dict(zip(COEFFICIENTS, [rng.uniform(0.3, 1.0), *rng.uniform(0.01, 0.2, 6)], strict=True))
    return moving(given, (rng.uniform(-1.2, 1.2), *rng.normal(size=3)))


def moving(given, motion):
    """Add the six numbers of a motion (tilt, tilt rate, precession rate, roll rate) and their derivatives."""
    tilt, w, P, f = motion
    S, C = math.sin(tilt), math.cos(tilt)
    six = {"S": S, "C": C, "T": S / C, "w": w, "o": P * C, "s": f + P * S, "f": f, "v": P + f * S}
    out = np.zeros(lossy_motion.SIZE)
    signs = np.array([math.copysign(1.0, f), math.copysign(1.0, six["v"]), 0.0])
    normal, *_ = lossy_motion.slopes(np.array([*motion, *out[4:]]), signs, coefficients(given), out)
    _, dw, dP, df = out[:4]
    slopes = {"dw": dw, "do": dP * C - P * S * w, "ds": df + dP * S + P * C * w}
    rates = {f"{name}/dtau": value for name, value in slopes.items()}
    return {**given, **six, **rates, "n": normal, "motion": motion, "slopes": out}


def coefficients(given):
    """Return the coefficients in the referee's order; friction is unlimited."""
    return np.array([*(given[name] for name in COEFFICIENTS), math.inf])


def with_forces(v):
    """Add the three forces by the page's formulas."""
    for line in FORMULAS["laws"]:
        v = {**v, line.first: line.value(v)}
    return v


def test_every_formula_is_tested():
    """Every displayed formula has a name, and a test in this file evaluates it."""
    assert PAGE.all_named
    assert PAGE.tested(__file__) == FORMULAS.keys()


def test_formulas_between_words_state_nothing():
    """Equations and conditions are displayed on their own line."""
    assert len(PAGE.inline()) > 20
    assert PAGE.statements() == []


def test_rates_forces_and_equations(v):
    """The page's laws and equations give the referee's accelerations and normal force."""
    check("rates", v)
    known = with_forces(v)
    check("forced", known, 1e-10)
    check("laws", known, defines=("r",))
    check("normal", known, 1e-10)


def test_what_the_losses_take(v):
    """The power is the derivative of the referee's energy along its motion, and the sum of its losses."""
    motion, out, h = np.array(v["motion"]), v["slopes"], 1e-5
    ahead, behind = (lossy_motion.energy(motion + side * h * out[:4], v["alpha"]) for side in (1.0, -1.0))
    check("power", {**with_forces(v), "dE/dtau": (ahead - behind) / (2.0 * h)}, 1e-7)
    check("power", {**with_forces(v), "dE/dtau": -out[lossy_motion.LOSSES : lossy_motion.PLACE].sum()}, 1e-10)


def test_an_upright_disk_that_is_slowed(rng):
    """The small parameter of an almost upright rolling disk, its change, and the swings' middle hold."""
    alpha, small = rng.uniform(0.2, 1.0), 1e-6
    losses = dict.fromkeys(("c_r", "c_c", "k", "q_M", "q_B"), 0.01) | {"alpha": alpha, "c_p": 0.0}
    motion = (small * rng.normal(), small * rng.normal(), small * rng.normal(), rng.uniform(0.9, 3.0))
    known = moving(losses, motion) | {"theta": motion[0]}
    s = known["s"]
    known["r"] = s * s / float(steady.critical_roll_rate_squared(alpha, 1.0, 1.0))
    check("rolling-square", known)
    (line,) = FORMULAS["wound"]
    known["c"] = line.value(known)
    slope = 0.5 * alpha * known["do/dtau"] + alpha * (known["ds/dtau"] * motion[0] + s * motion[1])
    # The error is of second order in the small parameter, over the loss.
    check("winding", known | {"dc/dtau": slope}, 1e-3 * small)
    # Rolling friction also acts on the tilt rate, which makes it small here.
    known["dw/dtau"] = moving(losses | {"c_r": 0.0}, motion)["dw/dtau"]
    known["theta_m"] = FORMULAS["swinging"][1].value(known)
    check("swinging", known, 1e-3 * small)


def test_how_far_a_slowed_disk_winds_up():
    """The page predicts the reach of the referee's disks that lose half of r - 1 over a hundred swings."""
    for alpha, tilt, rate in itertools.product((0.2, 0.5, 1.0), (1e-6, 0.0), (1e-6, 0.0)):
        if tilt == rate == 0.0:
            continue
        arm, start = 1e-4, 1.3 / math.sqrt(2.0 * (1.0 + alpha))
        given = lossy.starts(tilt=tilt, tilt_rate=rate, roll_rate=start, alpha=alpha, contour_friction=arm)
        last = math.sqrt(1.0 + 0.5 * 0.69) / 1.3 * start
        found = lossy.run(given, duration=(start - last) * (1.0 + alpha) / arm)
        known = {
            "alpha": alpha,
            "theta_0": tilt,
            "w_0": rate,
            "s_0": start,
            "s": last,
            "r_0": 1.69,
            "r": 1.345,
        }
        known["ds/dtau"] = -arm / (1.0 + alpha)
        ends = []
        for place in (known | {"s": start, "r": 1.69}, known):
            for line in FORMULAS["wound-up"]:
                place[line.first] = line.value(place)
            ends.append(place["theta_m"] + place["A"])
        reach = max(ends)
        # The last swing may be incomplete.
        assert 0.97 * reach < found.tilt_max[0] < 1.001 * reach, (alpha, tilt, rate)


@pytest.fixture
def si(rng):
    """Return values of a random disk and its losses in SI."""
    return {
        "pi": math.pi, "R": rng.uniform(0.01, 0.5), "g": rng.uniform(1.0, 10.0), "m": rng.uniform(0.01, 1.0),
        "kappa": rng.uniform(0.1, 1.0), "mu": rng.uniform(1e-5, 1e-4), "rho": rng.uniform(0.5, 2.0), "alpha": 0.5,
    }  # fmt: skip


def scaled(si):
    """Return the referee's coefficients of a disk in SI, by their names on the page."""
    words = {"alpha": si["alpha"], "radius": si["R"], "gravity": si["g"], "mass": si["m"]}
    air = {"air_viscosity": si["mu"], "air_density": si["rho"], "contour_damping": si["kappa"]}
    given = lossy.starts(**words, **air)[:, 0]
    (film, _), (layer, _) = (lossy.coefficients(given, law) for law in ("moffatt", "bildsten"))
    names = {name: float(value) for name, value in zip(COEFFICIENTS, film, strict=False)}
    return names | {"q_B": float(layer[lossy_motion.BILDSTEN])}


def test_coefficients(si):
    """They match the referee's."""
    check("coefficients", {**si, **scaled(si)})


def test_the_powers_of_the_sources(si):
    """For a uniform disk's wobble near flat, the losses of the air laws match their authors' formulas."""
    a = 1e-5
    rate = math.sqrt(2.0 / (si["alpha"] * math.sin(a)))
    wobble = (0.5 * math.pi - a, 0.0, rate, -rate * math.cos(a))
    found = {}
    for name, law in (("P_M", "q_M"), ("P_B", "q_B")):
        given = dict.fromkeys(COEFFICIENTS, 0.0) | {"alpha": si["alpha"], law: scaled(si)[law]}
        power = moving(given, wobble)["slopes"][lossy_motion.LOSSES : lossy_motion.PLACE].sum()
        found[name] = power * si["m"] * si["g"] * si["R"] * math.sqrt(si["g"] / si["R"])
    for line in FORMULAS["sources"]:
        assert line.value({**si, "a": a}) == pytest.approx(found[line.first], rel=1e-4)


def test_the_wobble(si, rng):
    """It is a steady motion with a resting center, and its energy matches the referee's."""
    tilt = rng.uniform(-1.5, 1.5)
    disk = si["alpha"], si["R"], si["g"]
    turning = math.sqrt(2.0 * si["g"] / (si["alpha"] * si["R"] * math.cos(tilt)))
    rolling = steady.steady_roll_rate(tilt, turning, *disk)
    # The center is S R away from the contact point, which moves at R times the roll rate.
    assert rolling + turning * math.sin(tilt) == pytest.approx(0.0, abs=1e-9 * turning)
    known = {**si, "theta": tilt, "dot psi": turning, "dot varphi": rolling}
    check("wobble", known, 1e-10)
    check("wobble-energy", {**known, "E": si["m"] * referee.energy((tilt, 0.0, turning, rolling), *disk)})


def test_powers_and_times():
    """The powers match the referee's near flat; the times match their quadrature and the closed forms."""
    for place, law in enumerate(LAWS):
        for alpha in (0.5, 0.8):
            power, time = FORMULAS["powers"][place], FORMULAS["times"][place]
            check_power_and_time(law, alpha, power, time)


def check_power_and_time(law, alpha, power, time):
    """Check a law's power and its time to flat against the referee, quadrature and closed form."""
    a, coefficient = 1e-6, 0.01
    name = {"contour": "c_c", "damping": "k", "moffatt": "q_M", "bildsten": "q_B", "rolling": "c_r"}[law]
    rate = math.sqrt(2.0 / (alpha * math.sin(a)))
    given = dict.fromkeys(COEFFICIENTS, 0.0) | {"alpha": alpha, name: coefficient}
    wobble = moving(given, (0.5 * math.pi - a, 0.0, rate, -rate * math.cos(a)))
    values = {"alpha": alpha, "c": coefficient, "k": coefficient, "q": coefficient}
    assert power.value({**values, "a": a}) == pytest.approx(
        wobble["slopes"][lossy_motion.LOSSES : lossy_motion.PLACE].sum(), rel=1e-5
    )

    taken = mpmath.quad(lambda x: 1.5 / power.value({**values, "a": float(x)}), [0.0, 0.01, 0.1])
    assert time.value({**values, "a_0": 0.1}) == pytest.approx(float(taken), rel=1e-6)
    form = lossy_wobble.time_to_flat(law, coefficient, alpha, 0.1)
    assert time.value({**values, "a_0": 0.1}) == pytest.approx(form, rel=1e-12)
    # "the time that is left to the power of ..."
    growth = math.log(time.value({**values, "a_0": 0.1}) / time.value({**values, "a_0": 0.05}), 2.0)
    assert 1.0 / growth == pytest.approx(lossy_wobble.EXPONENTS[law])


@pytest.mark.compiled
@pytest.mark.parametrize("turning", [0.0, 1.0])
def test_rolling_friction_holds(turning):
    """The referee's disk stays at rest just inside the condition and moves just outside it."""
    (line,) = FORMULAS["held"]
    arm, values = 0.1, {"alpha": 0.5, "R": 1.0, "g": 1.0, "c_r": 0.1, "dot psi": turning}
    least, greatest = 0.0, 0.5
    for _ in range(60):
        middle = 0.5 * (least + greatest)
        least, greatest = (middle, greatest) if line.holds({**values, "theta": middle}) else (least, middle)
    for tilt, moves in ((0.999 * least, False), (1.001 * least, True)):
        given = lossy.starts(tilt=tilt, precession_rate=turning, alpha=0.5, rolling_friction=arm)
        found = lossy.run(given, duration=3.0)
        assert (abs(found.tilt_max[0] - tilt) > 1e-9) == moves, found.ending
        assert moves or found.ending[0] in (endings.REST, endings.UNDISTURBED, endings.HORIZON)


def test_pivoting_friction_holds(v):
    """The force matches the one with which the referee keeps the turning rate at zero."""
    tilt, w, P, _ = v["motion"]
    motion = (tilt, w, P, -P / math.sin(tilt))
    free = moving({**v, "c_p": 0.0}, motion)
    dP = (free["do/dtau"] + P * free["S"] * w) / free["C"]
    df = free["ds/dtau"] - dP * free["S"] - P * free["C"] * w
    change = dP + free["S"] * df + free["C"] * w * motion[3]
    out = np.zeros(lossy_motion.SIZE)
    signs = np.array([math.copysign(1.0, motion[3]), 0.0, 0.0])
    *_, held = lossy_motion.slopes(np.array([*motion, *out[4:]]), signs, coefficients(v), out)
    check("held-turning", {**free, "v'": change, "lambda": held}, 1e-9)
