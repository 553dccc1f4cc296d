"""The tolerances of the regression check hold for random starts and are not too wide."""

import re
import sys

import audit_compare
import pytest


@pytest.mark.release
def test_random_cells_agree_as_far_as_they_state(monkeypatch, capsys):
    """Of 400 starts at five tolerances no value is off by more than allowed, but many come close."""
    monkeypatch.setattr(sys, "argv", ["audit_compare.py", "400", "1"])
    audit_compare.main()
    *lines, total = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"0 of \d{5} values differ by more than allowed; \d different endings", total)
    assert len(lines) == len(audit_compare.SETTINGS)
    for line in lines:
        shares = [float(word) for word in re.findall(r"tilt_max ([\d.e-]+)", line)]
        assert shares[0] > 0.02
