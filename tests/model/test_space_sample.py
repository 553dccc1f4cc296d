"""Some cells of an atlas are followed in space, which reveals errors of the reduction itself."""

import numpy as np
import pytest
from body_referee import REFERENCE

import sweep
from kernels.bodies.arrays import REDUCED
from sweep.commands.audit_report import audit_line
from sweep.model.disk.exact import REDUCE
from sweep.model.kernel import Kernel
from sweep.model.rigid_body import RigidBody

BALL = {
    "body": "ball", "offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38, "radius": 0.5, "gravity": 3.0,
    "tilt": "-0.7,0.3,0.9", "roll_rate": "0.2,0.9,1.7", "precession_rate": 0.4, "tilt_rate": "0,0.3",
    "criterion": "amplification:10",
}  # fmt: skip
DISK = {
    "tilt": "0.1,0.4", "roll_rate": "2,4,6", "precession_rate": 0.5, "tilt_rate": 0.3, "method": "exact",
    "criterion": "amplification:10",
}  # fmt: skip


@pytest.mark.parametrize("words", [BALL, DISK], ids=["ball", "disk"])
def test_the_reduction_agrees_with_motions_in_space(words):
    """At least eight cells are followed, including starts at rest."""
    audited = sweep.verify(sweep.run(sweep.SweepSpec(**words)), seed=3)
    findings = sweep.findings(audited)
    assert findings.passed
    compared = {row.name: row.judged for row in findings.statements if "in space" in row.against}
    assert set(compared) >= {"tilt_min", "tilt_max", "nutation_period"}
    assert int(findings.sampled.split()[0]) >= min(8, 6 if words is DISK else 18)
    assert "in space" in audit_line(findings)


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["tilt_min", "tilt_max", "nutation_period"])
@pytest.mark.parametrize("words", [BALL, DISK], ids=["ball", "disk"])
def test_an_error_of_the_reduction_is_seen(monkeypatch, words, name):
    """The atlas and its recomputation have the same error of 1e-7, so only the sample in space reveals it."""
    load = Kernel.load

    def reduce(*given):
        load(REDUCE)(*given)
        given[4][REDUCED.index(name)] *= 1.0 + 1e-7

    monkeypatch.setattr(Kernel, "load", lambda kernel: reduce if kernel == REDUCE else load(kernel))
    findings = sweep.findings(sweep.verify(sweep.run(sweep.SweepSpec(**words)), seed=3))
    assert not findings.passed
    assert name in {row.name for row in findings.wrong}


def test_an_atlas_without_a_motion_to_follow_says_so():
    """All cells fall, so the last line says that only the file was checked."""
    words = DISK | {"roll_rate": "0,0.1", "precession_rate": 0.0}
    findings = sweep.findings(sweep.verify(sweep.run(sweep.SweepSpec(**words)), seed=3))
    assert findings.sampled == ""
    assert "only the file" in audit_line(findings)


def test_a_start_at_rest_is_a_turning_point():
    """A motion that starts at one of its turning points has the same extremes and period."""
    body, *_ = REFERENCE["torus"]
    rigid = RigidBody(body.core, body.shift, body.edge, body.axial, body.transverse, body.square)
    for o, s in ((0.5, 0.6), (0.3, -0.2)):
        least, greatest, period = rigid.extremes(0.2, 0.0, o, s)
        kicked = rigid.extremes(0.2, 1e-9, o, s)
        assert 0.2 in (least, greatest)
        np.testing.assert_allclose((least, greatest, period), kicked, rtol=1e-8)
    assert np.isnan(rigid.extremes(0.2, 0.0, 0.5, 0.6, end=1.0)).all()
