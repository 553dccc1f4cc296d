"""How a comparison is told: in words, in JSON, in JUnit's XML, and by the exit status."""

import json
import shlex
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

import sweep
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words, to_junit
from sweep.cli import main

SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="0:3:13", tilt="0.1deg:40deg:6:log")


@pytest.fixture(scope="module")
def reference():
    """Return an atlas with falls."""
    return sweep.run(SPEC)


def changed(atlas, name, place, value):
    """Return a copy of an atlas with one value changed."""
    copy = atlas.copy(deep=True)
    copy[name].values[place] = value
    return copy


def test_the_report_and_the_junit_file_tell_the_same(reference):
    """The words name the worst cell in degrees; JUnit has one case per variable, failed where the variable differs."""
    comparison = compare(changed(reference, "tilt_max", (2, 3), 1.0), reference)
    text = in_words(comparison)
    assert text.startswith("DIFFERENT in tilt_max: 78 cells")
    where = f"roll_rate 0.5 rad s-1, tilt {np.degrees(reference.tilt.values[3]):.10g} deg"
    assert f"worst cell: {where}: 1 and " in text
    suite = ElementTree.fromstring(to_junit(comparison, "a.nc"))[0]
    assert suite.attrib == {"name": "a.nc", "tests": "24", "failures": "1", "errors": "0"}
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert failed == ["tilt_max"]


def test_the_command(tmp_path, monkeypatch, capsys, reference):
    """Exit 0 the same, 1 different, 2 not comparable; JSON on standard output and XML in a file for machines."""
    monkeypatch.chdir(tmp_path)
    sweep.save(reference, "a.nc")
    sweep.save(changed(reference, "tilt_max", (2, 3), np.nan), "b.nc")
    sweep.save(sweep.reclassify(reference, "departure:2deg"), "c.nc")
    (tmp_path / "text.nc").write_text("not netCDF")

    def run(line):
        monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(line)])
        with pytest.raises(SystemExit) as end:
            main()
        return end.value.code, *capsys.readouterr()

    assert run("compare a.nc a.nc") == (0, in_words(compare(reference, reference)) + "\n", "")
    status, out, err = run("compare b.nc a.nc --json --junit b.xml")
    assert (status, err) == (1, "")
    told = json.loads(out)
    assert (told["same"], told["new"], told["reference"]) == (False, "b.nc", "a.nc")
    assert next(each for each in told["findings"] if each["name"] == "tilt_max")["worst"]["new"] is None
    assert ElementTree.parse(tmp_path / "b.xml").getroot().get("failures") == "1"
    for line, said in [
        ("compare c.nc a.nc", "differ in criterion"),
        ("compare a.nc text.nc", "not a readable netCDF file"),
        ("compare a.nc missing.nc", "no such file"),
        ("compare a.nc a.nc --junit missing/a.xml", "no such folder"),
    ]:
        status, out, err = run(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert said in err


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
