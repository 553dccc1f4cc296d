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
    """Keep only some kinds of starts whose periods are audited."""
    kept = {kind: audit_extremes.PERIOD_KINDS[kind] for kind in kinds}
    monkeypatch.setattr(audit_extremes, "PERIOD_KINDS", kept)


@pytest.mark.release
def test_the_stated_error_is_a_promise():
    """Of 12,000 cells of six kinds 99.9 % are within twice their stated error, which is not too cautious."""
    # Each kind has few cells, so their share varies: the seed is fixed.
    assert audit_extremes.audit_errors(12_000, np.random.default_rng(14))


@pytest.mark.release
def test_nothing_beside_a_separatrix_is_bounded_and_wrong(rng, count):
    """At random separatrices no bounded cell is off by over twice its stated error; few are unresolved."""
    # There are few separatrices, so a single unresolvable one is a large share.
    assert audit_extremes.audit_separatrices(count(10, 24), rng, most_unresolved=0.2)


def test_tiny_starts_cost_little(rng):
    """Tilts and kicks below 1e-8 are resolved in at most 1e5 steps."""
    assert audit_extremes.audit_tiny(1_000, rng)


@pytest.mark.release
def test_brackets_hold_the_true_edge(rng):
    """Both ends of refined brackets have the verdicts of a 50-digit computation."""
    # With the first seed 3 of 13 brackets miss the edge if the stated errors are ignored.
    for source in (np.random.default_rng(3), rng):
        assert audit_extremes.audit_brackets(1, source)


#: Needs the reference of scripts/quadruple.c; without it only `test_periods_without_a_compiler` remains.
in_quadruple_precision = pytest.mark.skipif(
    not quadruple.available(), reason="no C compiler with __float128 and libquadmath"
)


@pytest.mark.release
@in_quadruple_precision
def test_periods_are_right_or_missing(rng, count, monkeypatch):
    """Periods of every kind are right to 1e-9, and no tilt error is stated too small."""
    # The others use 50 digits, which takes seconds.
    monkeypatch.setattr(
        audit_extremes, "true_swings", lambda given, _: quadruple.swings(given, audit_extremes.FALL)
    )
    assert audit_extremes.audit_periods(count(12, 40), rng)


@pytest.mark.slow_lane
def test_periods_without_a_compiler(rng, monkeypatch):
    """Without quadruple precision, a period of each kind is compared with 50 digits."""
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
    """Return a function that audits periods of one kind with a variable of the reduction scaled by a factor."""
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
    """Wrong and missing periods fail the audit."""
    assert factors("nutation_period", 1.0)
    assert not factors("nutation_period", 1.0 + 3e-9)
    assert not factors("nutation_period", np.nan)


@pytest.mark.release
@in_quadruple_precision
def test_an_audit_of_stated_errors_can_fail(factors):
    """Stated errors a thousand times too small fail the audit; the 50-digit check alone would not notice."""
    assert factors("tilt_error", 1.0)
    assert not factors("tilt_error", 1e-3)


@pytest.mark.release
def test_an_audit_can_fail(monkeypatch):
    """Results off by ten times their stated error fail every audit of them."""
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
    """A start with the summit's energy to 1e-14 is unresolved or turns at 11.659 deg, but does not pass."""
    given = referee.starts(
        tilt=0.3598374720049218, tilt_rate=-0.5529681782669364, precession_rate=-9.835676524413332,
        roll_rate=6.718888283501156, alpha=0.37, radius=0.012, gravity=1.62,
    )  # fmt: skip
    for tolerance in (1e-6, 1e-8, 1e-10):
        found = kernel_runner.run(given, fall_tilt=np.radians(89.0), tolerance=tolerance)
        assert found.ending[0] in (BOUNDED, UNRESOLVED)
        if found.ending[0] == BOUNDED:
            assert abs(np.degrees(found.least[0]) - 11.659) < 1e-3
