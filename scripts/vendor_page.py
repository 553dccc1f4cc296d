"""Fetch the libraries of the explorer's page from npm and compare them with the recorded hashes.

    python scripts/vendor_page.py             fetch all again; refuses what differs from SOURCES.toml
    python scripts/vendor_page.py --record    a version or a file was changed in SOURCES.toml: record the new hashes

`sweep/explorer/page/vendor/SOURCES.toml` names the packages, their versions and files. Files are used as published,
except for the names in `renamed`: a page that is one file has no folder, so it imports a module by its bare name, which
the page's import map resolves. Needs `npm`, which comes with the project's test environment.
"""

import argparse
import base64
import hashlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path
from typing import Any

VENDOR = Path(__file__).resolve().parents[1] / "sweep" / "explorer" / "page" / "vendor"
SOURCES = VENDOR / "SOURCES.toml"


def npm() -> str:
    """Return the path of npm: this environment's, or another one."""
    found = shutil.which("npm", path=str(Path(sys.executable).parent)) or shutil.which("npm")
    if found is None:
        raise SystemExit("npm was not found. Install the development tools: scripts/test --help")
    return found


def fetch(package: dict[str, Any], folder: Path) -> bytes:
    """Return the tarball of a package from npm."""
    wanted = f"{package['name']}@{package['version']}"
    done = subprocess.run(
        [npm(), "pack", "--silent", wanted], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise SystemExit(f"npm pack {wanted} failed:\n{done.stderr}")
    return (folder / done.stdout.split()[-1]).read_bytes()


def hash_tarball(tarball: bytes) -> str:
    """Return the hash of a tarball in npm's format."""
    return "sha512-" + base64.b64encode(hashlib.sha512(tarball).digest()).decode()


def read_files(package: dict[str, Any], tarball: bytes, folder: Path) -> dict[str, bytes]:
    """Return the content of each file of a package by its name in the vendor folder."""
    path = folder / "tarball"
    path.write_bytes(tarball)
    content = {}
    with tarfile.open(path) as archive:
        for file in package["files"]:
            member = archive.extractfile(f"package/{file['from']}")
            assert member is not None, file
            data = member.read()
            for old, new in file.get("renamed", {}).items():
                assert f'"{old}"'.encode() in data, (file["from"], old)
                data = data.replace(f'"{old}"'.encode(), f'"{new}"'.encode())
            content[file["to"]] = data
    return content


def record(packages: list[dict[str, Any]], preface: str) -> str:
    """Return the text of SOURCES.toml: its leading comment, then the packages."""
    lines = [preface.rstrip()]
    for package in packages:
        lines += ["", "[[packages]]"]
        lines += [f'{key} = "{package[key]}"' for key in ("name", "version", "licence", "integrity")]
        for file in package["files"]:
            lines += ["[[packages.files]]"]
            lines += [f'{key} = "{file[key]}"' for key in ("from", "to", "sha256")]
            if "renamed" in file:
                renamed = ", ".join(f'"{old}" = "{new}"' for old, new in file["renamed"].items())
                lines += [f"renamed = {{ {renamed} }}"]
    return "\n".join(lines) + "\n"


def read_preface(text: str) -> str:
    """Return the leading comment of SOURCES.toml."""
    return text[: text.index("[[packages]]")]


def main() -> None:
    """Fetch every package, compare or record its hashes, and write its files."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--record", action="store_true", help="record new hashes instead of refusing differences"
    )
    arguments = parser.parse_args()
    text = SOURCES.read_text(encoding="utf-8")
    packages = tomllib.loads(text)["packages"]
    files: dict[str, bytes] = {}
    differing = []
    with tempfile.TemporaryDirectory() as temporary:
        for package in packages:
            tarball = fetch(package, Path(temporary))
            if package.get("integrity") != hash_tarball(tarball):
                differing.append(f"the tarball of {package['name']}")
                package["integrity"] = hash_tarball(tarball)
            files |= read_files(package, tarball, Path(temporary))
            for file in package["files"]:
                found = hashlib.sha256(files[file["to"]]).hexdigest()
                if file.get("sha256") != found:
                    differing.append(file["to"])
                    file["sha256"] = found
    if differing and not arguments.record:
        raise SystemExit(f"Nothing was written, because these differ from {SOURCES}: {', '.join(differing)}.")
    for name, data in files.items():
        (VENDOR / name).write_bytes(data)
    SOURCES.write_text(record(packages, read_preface(text)), encoding="utf-8")
    print(f"{len(files)} files, {sum(map(len, files.values())) / 1000:.0f} kB, as in {SOURCES.name}.")


if __name__ == "__main__":
    main()
