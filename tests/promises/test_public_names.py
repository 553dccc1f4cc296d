"""docs/api.md lists all public names with arguments; type checkers find their types and users' mistakes."""

import inspect
import json
import re
import sys
import zipfile
from pathlib import Path

import pytest
from messages import assert_facts
from processes import CHECKOUT, python

import sweep

LISTING = (CHECKOUT / "docs" / "api.md").read_text(encoding="utf-8")
PROJECT = Path(__file__).parent / "user_project"
(LISTED,) = re.findall(r"^```text\n(.*?)^```$", LISTING, flags=re.MULTILINE | re.DOTALL)
LINES = [line for line in LISTED.splitlines() if line]
NAMES = [re.split(r"\(", line)[0] for line in LINES]


class Named:
    """A function used as a default; its repr is its name."""

    def __init__(self, function):
        self.function = function

    def __repr__(self):
        """Return the name."""
        return self.function.__name__


def member_of(owner, member):
    """Return a class's member: a function, a property, or None for a field."""
    found = inspect.getattr_static(owner, member, None)
    return getattr(owner, member) if isinstance(found, classmethod) else found


def spelled(name):
    """Return a public name as the page must write it: with its arguments if users call it."""
    owner, _, member = name.partition(".")
    found = member_of(getattr(sweep, owner), member) if member else getattr(sweep, owner)
    # The page lists only the name of a class that users do not create.
    if not callable(found) or (inspect.isclass(found) and f"\n{name}\n" in LISTED):
        return name
    parameters = [each for each in inspect.signature(found).parameters.values() if each.name != "self"]
    defaults = [
        Named(each.default) if inspect.isfunction(each.default) else each.default for each in parameters
    ]
    plain = [
        each.replace(annotation=each.empty, default=default)
        for each, default in zip(parameters, defaults, strict=True)
    ]
    return f"{name}{inspect.Signature(plain)}"


def test_every_public_name_is_listed():
    """The page lists each public name once, and no other."""
    assert sorted(name for name in NAMES if "." not in name) == sorted(sweep.__all__)
    assert len(NAMES) == len(set(NAMES))


def test_all_is_what_there_is():
    """Every name of `__all__` exists, has a home and is in `dir`; every name with a home is in `__all__`."""
    assert set(sweep.__all__) == {*sweep._HOME, "__version__"}
    assert dir(sweep) == sorted(sweep.__all__)
    assert all(getattr(sweep, name) is not None for name in sweep.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'rnu'"):
        _ = sweep.rnu


def test_the_arguments_are_those_of_the_page():
    """Names, order, defaults and keyword-only arguments are promised, so the page must match them."""
    for name, line in zip(NAMES, LINES, strict=True):
        owner, _, member = name.partition(".")
        fields = getattr(getattr(sweep, owner), "__dataclass_fields__", {})
        assert not member or hasattr(getattr(sweep, owner), member) or member in fields, name
        assert line == spelled(name)


def test_the_accessor_is_listed_whole():
    """Every public attribute of the accessor is listed."""
    asked = {name for name in vars(sweep.Eulerdisk) if not name.startswith("_")}
    assert {name.partition(".")[2] for name in NAMES if name.startswith("Eulerdisk.")} == asked


def test_every_public_name_says_what_it_is():
    """It has a docstring, or is a field of a result that its class describes."""
    for name in (each for each in NAMES if each != "__version__"):
        owner, _, member = name.partition(".")
        found = getattr(sweep, owner)
        if member and member not in getattr(found, "__dataclass_fields__", {}):
            found = getattr(found, member)
        assert found.__doc__, name


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Return the folder of a user's project, and the folder of the installed wheel."""
    folder = tmp_path_factory.mktemp("project")
    python("-m", "hatchling", "build", "-t", "wheel", "-d", folder / "wheel", folder=CHECKOUT)
    (wheel,) = (folder / "wheel").glob("*.whl")
    zipfile.ZipFile(wheel).extractall(folder / "installed")
    for each in PROJECT.glob("*.py"):
        (folder / each.name).write_bytes(each.read_bytes())
    return folder, folder / "installed"


def wrong_lines():
    """Return the numbers of the wrong lines in the project."""
    lines = (PROJECT / "mistakes.py").read_text(encoding="utf-8").splitlines()
    return {number for number, line in enumerate(lines, 1) if line.endswith("# wrong")}


def checked(project, *command):
    """Run a type checker in the project's folder."""
    folder, installed = project
    return python("-m", *command, folder=folder, packages=installed)


@pytest.mark.release
def test_mypy_sees_types_and_mistakes(project):
    """In strict mode it accepts the program, and finds each mistake and no others."""
    strict = ["mypy", "--strict", "--config-file=", "--no-error-summary"]
    done = checked(project, *strict, "analysis.py", "mistakes.py")
    found = re.findall(r"^(\w+)\.py:(\d+): error", done.stdout, flags=re.MULTILINE)
    assert {(file, int(line)) for file, line in found} == {("mistakes", line) for line in wrong_lines()}, (
        done.stdout
    )


@pytest.mark.release
def test_pyright_sees_types_and_mistakes(project):
    """In its strictest setting, which requires all types, it finds the same mistakes."""
    folder, installed = project
    settings = {
        "typeCheckingMode": "strict",
        "include": ["analysis.py", "mistakes.py"],
        "extraPaths": [str(installed)],
        "failOnWarnings": False,
    }
    (folder / "pyrightconfig.json").write_text(json.dumps(settings), encoding="utf-8")
    done = checked(project, "basedpyright", "--outputjson", "--pythonpath", sys.executable)
    report = json.loads(done.stdout)
    found = {
        (Path(each["file"]).stem, each["range"]["start"]["line"] + 1)
        for each in report["generalDiagnostics"]
        if each["severity"] == "error"
    }
    assert found == {("mistakes", line) for line in wrong_lines()}, done.stdout


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_typed_program_runs(project):
    """The program that the checkers accept runs with the installed packages."""
    done = checked(project, "analysis")
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r"True 0\.\d+ \S+", done.stdout.splitlines()[-1])
    assert_facts(done.stdout, "600 of 600 cells")
