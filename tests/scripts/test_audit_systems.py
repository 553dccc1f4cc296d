"""The audit of systems: its arguments, its counting, and its detection of a planted fault."""

import audit_systems
import numpy as np
import pytest
from bench.ten_systems import RANGES, driven_pendulum, magnets

from sweep.model.system import passes


@pytest.fixture
def one_system(monkeypatch):
    """Limit the audit to the driven pendulum."""
    pytest.importorskip("heyoka")
    monkeypatch.setattr(audit_systems, "RANGES", {driven_pendulum: RANGES[driven_pendulum]})


@pytest.mark.parametrize(
    "words", [[], ["other"], ["errors", "0"], ["labels", "-3"], ["events", "1", "2", "3"]]
)
def test_other_words(words, capsys):
    """An unknown part or an invalid number ends with status 2 and the list of parts."""
    assert audit_systems.main(words) == 2
    assert "audit_systems.py errors [COUNT] [SEED]" in capsys.readouterr().err


def test_what_counts_as_an_error():
    """The ratio is stated over true error; a value right to the last bit does not affect the median."""
    found = {"x_end": np.array([1.0, 2.0, 3.0]), "x_end_error": np.array([1e-9, 1e-9, 1e-9])}
    true = np.array([1.0, 2.0 + 1e-8, 3.0 - 1e-10], np.longdouble)
    ratios = audit_systems._ratios(found, "x_end", true, np.ones(3, bool))
    np.testing.assert_allclose(ratios, [np.inf, 0.1, 10.0], rtol=1e-5)


@pytest.mark.parametrize(
    ("ratios", "status"), [([5.0] * 2000 + [0.5] * 2, 0), ([5.0] * 500 + [0.5], 1), ([26.0], 1)]
)
def test_the_promises(ratios, status):
    """At most one in a thousand may exceed the stated error, and the median ratio may be at most 25."""
    assert audit_systems._print_errors("some", np.array(ratios)) == status


@pytest.mark.compiled
def test_stated_errors_are_held_against_true_ones(one_system, monkeypatch, capsys):
    """The stated errors of forty cells hold in 99 % of values; a thousandth of them does not."""
    monkeypatch.setattr(audit_systems, "_MOST_EXCEEDED", 0.01)
    monkeypatch.setattr(audit_systems, "_MOST_LARGE", 100.0)
    assert audit_systems.audit_errors(40, 1) == 0
    assert "all " in capsys.readouterr().out
    true = passes.Passes._error
    monkeypatch.setattr(passes.Passes, "_error", lambda *given: 1e-3 * true(*given))
    monkeypatch.setattr(passes, "_ROUNDING", 0.0)
    assert audit_systems.audit_errors(40, 1) == 1


@pytest.mark.compiled
def test_no_event_is_missed_or_invented(one_system, capsys):
    """Ten orbits at all levels miss and invent no event."""
    assert audit_systems.audit_events(10, 1) == 0
    assert "70 cells: missed 0, missed but counted 0, invented 0" in capsys.readouterr().out


@pytest.mark.compiled
def test_labels_are_held_against_heyoka(monkeypatch, capsys):
    """A label that replaces another one is wrong."""
    pytest.importorskip("heyoka")
    cells = next(audit_systems._sensitive(8, np.random.default_rng(1)))
    monkeypatch.setattr(audit_systems, "_sensitive", lambda count, rng: [cells])
    assert audit_systems.audit_labels(8, 1) == 0
    true = audit_systems._outcome
    monkeypatch.setattr(audit_systems, "_outcome", lambda *given: true(*given) + np.eye(6)[:, :1])
    assert audit_systems.audit_labels(8, 1) == 1
    assert magnets.definition.rates == cells[1].rates
