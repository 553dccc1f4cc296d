"""Short forms of scripts/audit_bodies.py; the long ones are run by hand."""

import audit_bodies
import numpy as np
import pytest


@pytest.mark.release
def test_the_engine_keeps_its_promises():
    """Endings, extremes, stated errors and periods hold for a few hundred bodies of each kind."""
    assert audit_bodies.audit_errors(400, np.random.default_rng(3))


@pytest.mark.release
def test_the_reduction_is_that_of_a_body_in_space(monkeypatch):
    """Some motions of each body agree; a tolerance below rounding fails."""
    assert audit_bodies.audit_space(24, np.random.default_rng(4))
    monkeypatch.setattr(audit_bodies, "NEAR", 1e-18)
    assert not audit_bodies.audit_space(4, np.random.default_rng(5))
