"""The page's libraries equal their records, and each is imported by a bare name."""

import hashlib
import re
import tomllib
from pathlib import Path

from cases import case

VENDOR = Path(__file__).parents[2] / "sweep" / "explorer" / "page" / "vendor"
PACKAGES = tomllib.loads((VENDOR / "SOURCES.toml").read_text(encoding="utf-8"))["packages"]
FILES = {file["to"]: file["sha256"] for package in PACKAGES for file in package["files"]}
MODULES = sorted(name for name in FILES if name.endswith(".js"))


def imported(name: str) -> set[str]:
    """Return the names of the modules that a file imports."""
    lines = (VENDOR / name).read_text(encoding="utf-8").splitlines()
    code = "\n".join(line for line in lines if not line.lstrip().startswith("*"))
    return set(re.findall(r"""\b(?:from|import)\s*\(?["']([\w@./-]+)["']""", code))


def test_every_file_is_the_recorded_one() -> None:
    """The folder contains exactly the files of SOURCES.toml, with their hashes."""
    held = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in VENDOR.iterdir()}
    del held["SOURCES.toml"]
    assert held == FILES


def test_every_package_brings_its_licence():
    """Each package has a license file of the recorded kind."""
    for package in PACKAGES:
        with case(package):
            (licence,) = (file["to"] for file in package["files"] if file["to"].endswith(".LICENSE"))
            words = {"MIT": "Permission is hereby granted, free of charge"}
            assert words[package["licence"]] in (VENDOR / licence).read_text(encoding="utf-8")


def test_modules_import_bare_names_of_each_other():
    """A vendored module imports only vendored modules by bare names, so one file without folders can contain them."""
    for name in MODULES:
        with case(name):
            known = {module.removesuffix(".js").replace("three.", "three/") for module in MODULES}
            assert imported(name) <= known


def test_imports_are_seen() -> None:
    """The search finds the imports of minified and of plain modules."""
    assert imported("three.core.js") == set()
    assert imported("three.js") == {"three/core"}
    assert imported("three.orbit_controls.js") == {"three"}
