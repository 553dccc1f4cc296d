"""Short forms of scripts/audit_extremes.py; the long ones are run by hand."""

import audit_extremes
import kernel_runner
import numpy as np
import pytest
import quadruple
import referee

from kernels.disk.endings import BOUNDED, UNRESOLVED

pytestmark = pytest.mark.compiled


def keep_kinds(monkeypatch, *kinds):
    """Leave out all other kinds of starts whose periods are audited."""
    kept = {kind: audit_extremes.PERIOD_KINDS[kind] for kind in kinds}
    monkeypatch.setattr(audit_extremes, "PERIOD_KINDS", kept)


@pytest.mark.release
def test_the_stated_error_is_a_promise():
    """Of 12,000 cells of six kinds 99.9 % are within twice their stated error, which is no more cautious than that."""
    # the share of a kind is a number of few cells here: the seed is fixed
    assert audit_extremes.audit_errors(12_000, np.random.default_rng(14))


@pytest.mark.release
def test_nothing_beside_a_separatrix_is_bounded_and_wrong(rng, count):
    """At random separatrices no bounded cell is wrong by more than twice its stated error; few are unresolved."""
    # few separatrices: one on which nothing can be resolved is a large share
    assert audit_extremes.audit_separatrices(count(10, 24), rng, most_unresolved=0.2)


def test_tiny_starts_cost_little(rng):
    """Tilts and kicks below 1e-8 take at most 1e5 steps and are resolved."""
    assert audit_extremes.audit_tiny(1_000, rng)


@pytest.mark.release
def test_brackets_hold_the_true_edge(rng):
    """Both ends of refined brackets have the verdicts that 50 digits give."""
    # of the first of these 3 of 13 miss the edge if the stated errors are left out
    for source in (np.random.default_rng(3), rng):
        assert audit_extremes.audit_brackets(1, source)


#: Needs the reference of scripts/quadruple.c; without it, `test_periods_without_a_compiler` is left.
in_quadruple_precision = pytest.mark.skipif(
    not quadruple.available(), reason="no C compiler with __float128 and libquadmath"
)


@pytest.mark.release
@in_quadruple_precision
def test_periods_are_right_or_missing(rng, count, monkeypatch):
    """Periods of every kind are right to 1e-9, and no error of a tilt is stated too small."""
    # the others by 50 digits, which take seconds
    monkeypatch.setattr(
        audit_extremes, "true_swings", lambda given, _: quadruple.swings(given, audit_extremes.FALL)
    )
    assert audit_extremes.audit_periods(count(12, 40), rng)


@pytest.mark.slow_lane
def test_periods_without_a_compiler(rng, monkeypatch):
    """Where quadruple precision cannot be had, a period of each kind is compared with 50 digits."""
    monkeypatch.setattr(quadruple, "available", lambda: False)
    keep_kinds(monkeypatch, "slow")
    assert audit_extremes.audit_periods(3, rng)


@pytest.mark.slow_lane
@in_quadruple_precision
def test_quadruple_precision_is_that_of_50_digits(rng):
    """Periods and turning points of both references agree to all digits of a double."""
    given = audit_extremes.random_starts("nearly flat", 40, rng)
    found = quadruple.swings(given, audit_extremes.FALL)
    cell = np.flatnonzero(np.isfinite(found[0]))[:1]
    truth = audit_extremes.true_swings(given[:, cell], True)
    assert found[0, cell] == pytest.approx(truth[0], rel=1e-12)
    assert found[2:, cell] == pytest.approx(audit_extremes.fifty_digits(given, cell), rel=3e-16)


@pytest.fixture(name="factors")
def _factors(monkeypatch):
    """Return a function that audits periods of one kind, a variable of the reduction multiplied by a factor."""
    right = audit_extremes.exact
    keep_kinds(monkeypatch, "small alpha")

    def factors(name, factor):
        def wrong(*arguments, **options):
            found = right(*arguments, **options)
            return {**found, name: found[name] * factor}

        monkeypatch.setattr(audit_extremes, "exact", wrong)
        return audit_extremes.audit_periods(40, np.random.default_rng(1))

    return factors


@pytest.mark.release
def test_an_audit_of_periods_can_fail(factors):
    """Wrong periods and missing ones break the promise."""
    assert factors("nutation_period", 1.0)
    assert not factors("nutation_period", 1.0 + 3e-9)
    assert not factors("nutation_period", np.nan)


@pytest.mark.release
@in_quadruple_precision
def test_an_audit_of_stated_errors_can_fail(factors):
    """Stated errors of a thousandth break the promise; 50 digits alone do not look at them."""
    assert factors("tilt_error", 1.0)
    assert not factors("tilt_error", 1e-3)


@pytest.mark.release
def test_an_audit_can_fail(monkeypatch):
    """Results that are wrong by ten times their stated error break every promise about them."""
    right = kernel_runner.run

    def wrong(*arguments, **options):
        found = right(*arguments, **options)
        found.greatest[:] += 10.0 * found.tilt_error + 1e-9
        return found

    monkeypatch.setattr(kernel_runner, "run", wrong)
    monkeypatch.setattr(audit_extremes, "KINDS", ("slow",))
    assert not audit_extremes.audit_errors(100, np.random.default_rng(1))
    assert not audit_extremes.audit_separatrices(3, np.random.default_rng(1))
    assert not audit_extremes.audit_tiny(200, np.random.default_rng(1))


def test_a_pass_by_less_than_the_loss_is_not_taken_for_truth():
    """A start whose energy is that of the summit to 1e-14 is unresolved, or turns at 11.659 deg: it does not pass."""
    given = referee.starts(
        tilt=0.3598374720049218, tilt_rate=-0.5529681782669364, precession_rate=-9.835676524413332,
        roll_rate=6.718888283501156, alpha=0.37, radius=0.012, gravity=1.62,
    )  # fmt: skip
    for tolerance in (1e-6, 1e-8, 1e-10):
        found = kernel_runner.run(given, fall_tilt=np.radians(89.0), tolerance=tolerance)
        assert found.ending[0] in (BOUNDED, UNRESOLVED)
        if found.ending[0] == BOUNDED:
            assert abs(np.degrees(found.least[0]) - 11.659) < 1e-3
