"""A comparison as text, JSON, JUnit XML and exit status."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from comparing import SPEC, changed
from messages import assert_facts, assert_in_order

import sweep
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words, to_junit


def told_of(name, text):
    """Return the report lines about a variable, including its worst cell and the reason."""
    return re.search(rf"^\w+ +{name} .*\n(?: .*\n)*", text, re.MULTILINE)[0]


@pytest.fixture(scope="module")
def reference():
    """Return an atlas with falls."""
    return sweep.run(SPEC)


def test_the_report_and_the_junit_file_tell_the_same(reference):
    """The text names the worst cell in degrees; JUnit has one case per variable, failed if it differs."""
    comparison = compare(changed(reference, "tilt_max", (2, 3), 1.0), reference)
    text = in_words(comparison)
    assert_in_order(text.splitlines()[0], "DIFFERENT", "tilt_max", "1 of 78")
    value = float(reference["tilt_max"][2, 3])
    (finding,) = (each for each in comparison.findings if each.different)
    assert_in_order(
        told_of("tilt_max", text),
        *("DIFFERS", "tilt_max", "1 of 78", f"{value - 1.0:.2g} rad", "2e-08", "roll_rate 0.5 rad s-1"),
        *(f"tilt {np.degrees(reference.tilt.values[3]):.10g} deg", "1", f"{value:.17g}", finding.reason),
    )
    suite = ElementTree.fromstring(to_junit(comparison, "a.nc", 4.8))[0]
    assert suite.attrib == {"name": "a.nc", "tests": "24", "failures": "1", "errors": "0", "time": "4.800"}
    assert {case.get("time") for case in suite} == {"0.2000"}
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert failed == ["tilt_max"]


def test_the_outcome_is_identical_or_within_tolerance(reference):
    """The outcome is "identical" only for equal bits; otherwise each variable has its difference and tolerance."""
    words = in_words(compare(reference, reference))
    assert_in_order(words.splitlines()[0], "identical", "78 cells", "24 variables")
    assert words.count("\nidentical ") == 24
    value = float(reference["tilt_max"][2, 3])
    words = in_words(compare(changed(reference, "tilt_max", (2, 3), value + 5e-9), reference))
    first = words.splitlines()[0]
    assert_in_order(first, "within", "78 cells")
    assert_facts(first, "25 %", "tilt_max")
    assert_in_order(told_of("tilt_max", words), "within", "tilt_max", "5e-09 rad", "2e-08", "25 %")
    assert_in_order(told_of("tilt_min", words), "identical", "tilt_min", "78")
    first = in_words(compare(reference, reference.drop_vars("steps"))).splitlines()[0]
    assert_in_order(first, "within", "78 cells")
    assert "%" not in first


@pytest.mark.slow_lane
def test_the_command(command, tmp_path, reference):
    """`compare` exits with 0 if the same, 1 if different and 2 if not comparable, and writes JSON and XML."""
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
        ("compare c.nc a.nc", ["criterion", "departure:2deg", "departure:5deg"]),
        ("compare a.nc text.nc", ["text.nc", "netCDF-4", "10 bytes"]),
        ("compare a.nc missing.nc", ["missing.nc", "no such file"]),
        ("compare a.nc a.nc --junit missing/a.xml", ["missing/a.xml", "mkdir -p missing"]),
    ]:
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert_facts(err, *facts)


def test_odd_characters_reach_neither_terminal_nor_xml(reference):
    """Control characters in names and attributes are escaped in the XML and on the terminal."""
    odd = reference.assign_attrs(title='bell \x07 escape \x1b[31m and ]]> <&">')
    odd["tilt_max"] = odd["tilt_max"].assign_attrs(units="rad\x00\ufffe\udc80")
    comparison = compare(odd, reference)
    text = in_words(comparison)
    assert all(each.isprintable() for each in text.splitlines())
    assert r"bell \x07 escape \x1b[31m and ]]> <&" in text
    suite = ElementTree.fromstring(to_junit(comparison, 'odd \x07\x1b <&"\udcff.nc').encode("utf-8"))[0]
    assert suite.get("name") == r"odd \x07\x1b <&\"\udcff.nc".replace('\\"', '"')
    (failed,) = (case for case in suite if case.find("failure") is not None)
    assert_in_order(failed.find("failure").get("message"), "units", r"rad\x00\ufffe\udc80", "rad")


def test_flags_are_named(reference):
    """Differing verdicts and endings are reported by name, without a size."""
    stable = changed(reference, "stability", (12, 0), 2)
    assert reference["stability"].values[12, 0] == 1
    comparison = compare(changed(stable, "ending", (12, 1), 3), reference)
    text = in_words(comparison)
    assert_in_order(text.splitlines()[0], "DIFFERENT", "ending", "1 of 78", "stability", "1 of 78")
    reason = {each.name: each.reason for each in comparison.findings}
    for name, tilt, *values in (
        ("ending", "0.3314454017 deg", "horizon", "bounded"),
        ("stability", "0.1 deg", "unstable", "stable"),
    ):
        told = told_of(name, text)
        where = ("roll_rate 3 rad s-1", f"tilt {tilt}")
        assert_in_order(told, "DIFFERS", name, "1 of 78", *where, *values, reason[name])
        assert not re.search(r"\d", re.sub(r"1 of 78|roll_rate 3 rad s-1|tilt [\d.]+ deg", "", told)), told


def test_the_reason_is_that_of_the_question(reference):
    """The report gives the reason for its tolerances: exact bits, a given number, or a common part."""
    value = float(reference["tilt_max"][2, 3])
    exactly = compare(changed(reference, "tilt_max", (2, 3), value + 5e-9), reference, exact=True)
    (every_bit,) = {each.reason for each in exactly.findings}
    assert "bit" in every_bit
    assert_facts(told_of("tilt_max", in_words(exactly)), every_bit)
    reasons = {each.name: each.reason for each in compare(reference, reference).findings}
    assert "logarithm" in reasons["tilt"]
    assert "logarithm" not in reasons["alpha"]
    part = compare(changed(reference, "tilt_max", (2, 3), 1.0), reference, common=True)
    first = in_words(part).splitlines()[0]
    assert_in_order(first, "DIFFERENT", "tilt_max", "1 of 78")
    assert_facts(first, "78 common cells")
