"""JUnit XML for CI servers: the checks and their failures."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from sweep.errors import printable


@dataclass(frozen=True)
class Case:
    """A test: its name, its duration in seconds, and what is wrong (empty if it passed).

    `kind` is ``failure`` or ``error``; `details` are printed below `wrong`.
    """

    name: str
    seconds: float = 0.0
    wrong: str = ""
    kind: str = "failure"
    details: str = ""


def to_xml(suites: Iterable[tuple[str, Sequence[Case]]]) -> str:
    """Return the XML of test suites, each with a name and tests."""
    held = [(printable(name), cases) for name, cases in suites]
    root = ElementTree.Element("testsuites", _counts([case for _, cases in held for case in cases]))
    for name, cases in held:
        suite = ElementTree.SubElement(root, "testsuite", {"name": name, **_counts(cases)})
        for case in cases:
            attributes = {"classname": name, "name": case.name, "time": f"{case.seconds:.4f}"}
            test = ElementTree.SubElement(suite, "testcase", attributes)
            if case.wrong:
                message = printable(case.wrong)
                ElementTree.SubElement(test, case.kind, {"message": message}).text = case.details or message
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _counts(cases: Sequence[Case]) -> dict[str, str]:
    kinds = [case.kind for case in cases if case.wrong]
    return {
        "tests": str(len(cases)),
        "failures": str(kinds.count("failure")),
        "errors": str(kinds.count("error")),
        "time": f"{sum(case.seconds for case in cases):.3f}",
    }
