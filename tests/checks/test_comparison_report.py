"""How a comparison is told: in words, in JSON, in JUnit's XML, and by the exit status."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from comparing import SPEC, changed
from messages import assert_facts

import sweep
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words, to_junit


@pytest.fixture(scope="module")
def reference():
    """Return an atlas with falls."""
    return sweep.run(SPEC)


def test_the_report_and_the_junit_file_tell_the_same(reference):
    """The words name the worst cell in degrees; JUnit has one case per variable, failed where the variable differs."""
    comparison = compare(changed(reference, "tilt_max", (2, 3), 1.0), reference)
    text = in_words(comparison)
    assert text.startswith("DIFFERENT in tilt_max (1 of 78 values)\n")
    where = f"roll_rate 0.5 rad s-1, tilt {np.degrees(reference.tilt.values[3]):.10g} deg"
    assert f"worst cell: {where}: 1 and " in text
    assert re.search(
        r"DIFFERS +tilt_max +1 of 78 differs, largest difference [\d.]+ rad, allowed 2e-08\n", text
    )
    assert "because each extreme tilt is as near to the true one as its atlas states" in text
    suite = ElementTree.fromstring(to_junit(comparison, "a.nc", 4.8))[0]
    assert suite.attrib == {"name": "a.nc", "tests": "24", "failures": "1", "errors": "0", "time": "4.800"}
    assert {case.get("time") for case in suite} == {"0.2000"}
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert failed == ["tilt_max"]


def test_the_outcome_is_identical_or_within_tolerance(reference):
    """Identical is said of equal bits alone; else the largest difference and what is allowed, for each variable."""
    words = in_words(compare(reference, reference))
    assert words.startswith("identical: 78 cells, all 24 variables bit for bit\n")
    assert "made alike: no attribute differs" in words
    value = float(reference["tilt_max"][2, 3])
    words = in_words(compare(changed(reference, "tilt_max", (2, 3), value + 5e-9), reference))
    assert words.startswith("within tolerance: 78 cells; at most 25 % of what is allowed (tilt_max)\n")
    assert re.search(
        r"\nwithin +tilt_max +largest difference 5e-09 rad, allowed 2e-08, at most 25 % of what is allowed\n",
        words,
    )
    assert re.search(r"\nidentical tilt_min +78 equal\n", words)
    named = compare(reference, reference.drop_vars("steps"))
    assert in_words(named).startswith("within tolerance: 78 cells\n")


def test_the_command(command, tmp_path, reference):
    """Exit 0 the same, 1 different, 2 not comparable; JSON on standard output and XML in a file for machines."""
    sweep.save(reference, "a.nc")
    sweep.save(changed(reference, "tilt_max", (2, 3), np.nan), "b.nc")
    sweep.save(sweep.reclassify(reference, "departure:2deg"), "c.nc")
    value = float(reference["tilt_max"][2, 3])
    sweep.save(changed(reference, "tilt_max", (2, 3), value + 5e-7), "d.nc")
    (tmp_path / "text.nc").write_text("not netCDF")

    assert command("compare a.nc a.nc") == (0, in_words(compare(reference, reference)) + "\n", "")
    status, out, err = command("compare b.nc a.nc --json --junit b.xml")
    assert (status, err) == (1, "")
    told = json.loads(out)
    assert (told["outcome"], told["same"], told["new"], told["reference"]) == (
        "different",
        False,
        "b.nc",
        "a.nc",
    )
    assert next(each for each in told["findings"] if each["name"] == "tilt_max")["worst"]["new"] is None
    assert ElementTree.parse(tmp_path / "b.xml").getroot().get("failures") == "1"
    assert command("compare d.nc a.nc")[0] == 1
    assert command("compare d.nc a.nc --tolerance tilt_max=1e-6 --tolerance steps=3")[0] == 0
    assert command("compare a.nc a.nc --exact")[0] == 0
    assert command("compare d.nc a.nc --exact --json")[0] == 1
    for line, facts in [
        ("compare a.nc a.nc --tolerance tilt_max", ["NAME=VALUE"]),
        ("compare a.nc a.nc --tolerance ending=1", ["ending=1", "tilt_min"]),
        ("compare a.nc a.nc --exact --tolerance tilt_max=1", ["exact", "tolerances"]),
        ("compare c.nc a.nc", ["criterion (departure:2deg and departure:5deg)"]),
        ("compare a.nc text.nc", ["text.nc", "netCDF-4", "10 bytes"]),
        ("compare a.nc missing.nc", ["missing.nc", "no such file"]),
        ("compare a.nc a.nc --junit missing/a.xml", ["missing/a.xml", "mkdir -p missing"]),
    ]:
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert_facts(err, *facts)


def test_odd_characters_reach_neither_terminal_nor_xml(reference):
    """Names and attributes with control characters are escaped: the XML is well-formed, the terminal is left alone."""
    odd = reference.assign_attrs(title='bell \x07 escape \x1b[31m and ]]> <&">')
    odd["tilt_max"] = odd["tilt_max"].assign_attrs(units="rad\x00\ufffe\udc80")
    comparison = compare(odd, reference)
    text = in_words(comparison)
    assert all(each.isprintable() for each in text.splitlines())
    assert r"bell \x07 escape \x1b[31m and ]]> <&" in text
    suite = ElementTree.fromstring(to_junit(comparison, 'odd \x07\x1b <&"\udcff.nc').encode("utf-8"))[0]
    assert suite.get("name") == r"odd \x07\x1b <&\"\udcff.nc".replace('\\"', '"')
    (failed,) = (case for case in suite if case.find("failure") is not None)
    assert r"its units differ: rad\x00\ufffe\udc80 and rad" in failed.find("failure").get("message")


def test_flags_are_named(reference):
    """Codes have neither a difference nor a size: verdicts and endings that differ are told in words."""
    stable = changed(reference, "stability", (12, 0), 2)
    assert reference["stability"].values[12, 0] == 1
    text = in_words(compare(changed(stable, "ending", (12, 1), 3), reference))
    assert text.startswith("DIFFERENT in ending (1 of 78 values), stability (1 of 78 values)\n")
    assert re.search(
        r"DIFFERS +ending +1 of 78 differs\n +worst cell: roll_rate 3 rad s-1, .*: horizon and bounded\n",
        text,
    )
    assert re.search(r"DIFFERS +stability +1 of 78 differs\n +worst cell: .*: unstable and stable\n", text)
    assert text.count("nothing is allowed because a decision is the same or it is not") == 2
    assert "largest difference" not in text


def test_the_reason_is_that_of_the_question(reference):
    """Exactly: every bit; a number that was given has no logarithm; a part is said to be one."""
    value = float(reference["tilt_max"][2, 3])
    text = in_words(compare(changed(reference, "tilt_max", (2, 3), value + 5e-9), reference, exact=True))
    assert "nothing is allowed because every bit has to be the same" in text
    reasons = {each.name: each.reason for each in compare(reference, reference).findings}
    assert "logarithm" in reasons["tilt"]
    assert "logarithm" not in reasons["alpha"]
    part = compare(changed(reference, "tilt_max", (2, 3), 1.0), reference, common=True)
    assert in_words(part).startswith(
        "DIFFERENT in tilt_max (1 of 78 values); compared were 78 common cells\n"
    )
