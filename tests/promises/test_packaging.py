"""What users install: both packages, presets, one version, one command, and self-explanatory scripts."""

import email
import os
import shutil
import stat
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from messages import refused

import sweep
from sweep import platforms

CHECKOUT = Path(__file__).resolve().parents[2]
COMMANDS = ("scripts/atlas", "scripts/gallery", "scripts/soak", "scripts/test", "scripts/release", ".ci/run")
PRESETS = ("rolling", "spinning", "circling")


def succeeded(*command: str | Path, **options: object) -> str:
    """Return a command's output, or fail with all its messages."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build(target: str, folder: Path, source: Path = CHECKOUT) -> None:
    """Build a wheel or an sdist into a folder, without a network."""
    succeeded(sys.executable, "-m", "hatchling", "build", "-t", target, "-d", folder, cwd=source)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """Yield the wheel, built offline without writing into the checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    build("wheel", folder)
    (built,) = folder.glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        yield archive


@pytest.fixture(scope="module")
def installed(wheel: zipfile.ZipFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files that the wheel would install."""
    folder = tmp_path_factory.mktemp("installed")
    wheel.extractall(folder)
    return folder


def metadata(wheel: zipfile.ZipFile, name: str) -> str:
    """Return one metadata file of the wheel."""
    (path,) = (path for path in wheel.namelist() if path.endswith(f".dist-info/{name}"))
    return wheel.read(path).decode()


def test_one_list_of_systems(monkeypatch):
    """Front pages, classifiers and the refusal of other systems name the same ones; WSL counts as Linux."""
    with (CHECKOUT / "pyproject.toml").open("rb") as file:
        classifiers = tomllib.load(file)["project"]["classifiers"]
    systems = {each.rpartition(" :: ")[2] for each in classifiers if each.startswith("Operating System")}
    assert systems == {"Linux", "MacOS"}
    needed = "From a checkout, with Python 3.13 or newer (venv and pip) and bash, on Linux, macOS or WSL:"
    for page in ("README.md", "docs/index.md"):
        assert needed in (CHECKOUT / page).read_text().splitlines()
    monkeypatch.setitem(sys.modules, "fcntl", None)
    with refused("Linux", "macOS", "WSL"):
        platforms.check_system()


@pytest.mark.slow_lane
def test_wheel_holds_the_two_packages_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    """The wheel contains every file of sweep and kernels, byte for byte, and no tests or caches."""
    expected = {
        path.relative_to(CHECKOUT).as_posix(): path.read_bytes()
        for package in ("sweep", "kernels")
        for path in (CHECKOUT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {path for path in wheel.namelist() if ".dist-info/" not in path} == set(expected)
    assert [path for path, content in expected.items() if wheel.read(path) != content] == []


@pytest.mark.slow_lane
def test_installed_files_give_the_presets_and_the_model(installed: Path, tmp_path: Path) -> None:
    """Outside the checkout, all presets of the disk and a system load from the installed files."""
    read = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import sweep\n"
        "print(*(sweep.SweepSpec.preset(name).model.name for name in sys.argv[2:]), sweep.__file__)"
    )
    said = succeeded(sys.executable, "-P", "-c", read, installed, *PRESETS, "kapitza", cwd=tmp_path)
    assert said.split() == ["disk"] * len(PRESETS) + ["kapitza", str(installed / "sweep" / "__init__.py")]


@pytest.mark.release
def test_sdist_builds_the_wheel_and_holds_the_tests(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    """The sdist contains all that git tracks, nothing else in the checkout, and builds the same wheel."""
    build("sdist", tmp_path)
    (built,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(built) as archive:
        archive.extractall(tmp_path, filter="data")
    unpacked = tmp_path / built.name.removesuffix(".tar.gz")
    held = {path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*") if path.is_file()}
    assert {name.partition("/")[0] for name in held} == {
        *("sweep", "kernels", "scripts", "tests", "docs", ".ci"),
        *("LICENSE", "README.md", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md"),
        *("pyproject.toml", ".gitignore", "PKG-INFO"),
    }
    kept = subprocess.run(
        ["git", "ls-files", "-z"], cwd=CHECKOUT, capture_output=True, text=True, check=False
    )
    assert set(filter(None, kept.stdout.split("\0"))) - held == set()
    build("wheel", tmp_path, unpacked)
    (again,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(again) as other:
        assert {each.filename: each.CRC for each in other.infolist()} == {
            each.filename: each.CRC for each in wheel.infolist()
        }


@pytest.mark.slow_lane
def test_metadata(wheel: zipfile.ZipFile) -> None:
    """The metadata state name, version, Python, license, one console script and one pytest plugin."""
    fields = email.message_from_string(metadata(wheel, "METADATA"))
    names = ("Name", "Version", "Requires-Python", "License-Expression")
    assert [fields[name] for name in names] == [
        "eulerdisk",
        sweep.__version__,
        ">=3.13",
        "BSD-3-Clause AND MIT",
    ]
    assert metadata(wheel, "licenses/LICENSE") == (CHECKOUT / "LICENSE").read_text(encoding="utf-8")
    written = metadata(wheel, "entry_points.txt").strip()
    assert written == (
        "[console_scripts]\neulerdisk = sweep.cli:main\n\n[pytest11]\neulerdisk_atlas = sweep.pytest_plugin"
    )


@pytest.mark.slow_lane
def test_installed_command_runs_away_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    """The installed entry point, not the checkout's, answers --help in any folder."""
    entry = "import sys; from sweep import __file__, cli; print(__file__); sys.exit(cli.main())"
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    said = succeeded(sys.executable, "-c", entry, "--help", cwd=tmp_path, env=environment)
    assert Path(said.splitlines()[0]) == installed / "sweep" / "__init__.py"
    assert "Usage" in said


@pytest.mark.slow_lane
def test_users_and_developers_install_different_things(wheel: zipfile.ZipFile) -> None:
    """Extras are for users; developer tools are a dependency group that users cannot install by mistake."""
    extras = email.message_from_string(metadata(wheel, "METADATA")).get_all("Provides-Extra")
    assert set(extras) == {"dask", "formats", "bench", "cuda"}
    groups = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["dependency-groups"]
    assert any(str(each).startswith("pytest-cov>") for each in groups["test"])
    assert {"include-group": "docs"} in groups["test"]


def test_scripts_are_executable() -> None:
    """The commands of the README and of CI are executable in the checkout."""
    assert [each for each in COMMANDS if not (CHECKOUT / each).stat().st_mode & stat.S_IXUSR] == []


def test_scripts_ask_for_a_usable_python(tmp_path: Path) -> None:
    """Without Python 3.13 a script exits with 2 and says what it needs, what it tried and what to do."""
    checkout = tmp_path / "a check out"
    for folder in ("scripts", ".ci"):
        shutil.copytree(CHECKOUT / folder, checkout / folder, ignore=shutil.ignore_patterns("node_modules"))
    placeholder = tmp_path / "python3"
    placeholder.write_text("#!/bin/sh\nexit 127\n")
    placeholder.chmod(0o755)
    environment = {**os.environ, "PYTHON": str(placeholder)}
    for command in COMMANDS:
        done = subprocess.run(
            [checkout / command], env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 2, command
        for said in ("Python 3.13 or newer", str(placeholder), "PYTHON=/path/to/python3"):
            assert said in done.stderr, command
    assert not (checkout / ".venv").exists()
