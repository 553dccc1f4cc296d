"""Spec files and presets: where they are, and the words in them."""

import errno
import os
import stat
from collections.abc import Mapping
from pathlib import Path

import sweep.model.system
from sweep.errors import RequestError, as_path, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.request.suggestions import suggestion

#: Bytes of a spec file at most, a list of 50,000 values; and dots between two commas or ends of lines: of a key of
#: 20,000 parts the parser makes gigabytes.
_MOST_BYTES, _MOST_DOTS = 2**20, 50

#: Presets of systems: each a file of requests beside the file of its system.
_SYSTEMS = Path(sweep.model.system.__file__).with_name("presets")

#: Tables of a spec file that hold a sweep each, for `eulerdisk batch`; and how they are misspelt.
SWEEP_TABLES = ("sweep", "sweeps")


def presets(model: Model) -> tuple[str, ...]:
    """Return the names of the presets of a model."""
    return _presets_in(model.presets)


def _presets_in(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in folder.glob("*.toml")))


def system_presets() -> tuple[str, ...]:
    """Return the names of the presets of systems."""
    return _presets_in(_SYSTEMS)


def system_preset_file(name: str) -> Path:
    """Return the file with the system of a preset."""
    return _SYSTEMS / f"{name}.py"


def _every_preset() -> tuple[str, ...]:
    """Return the names of all presets, those of the default model first and those of systems last."""
    return (*(name for model in registry.every() for name in presets(model)), *system_presets())


def find_spec_file(spec: str | Path) -> Path:
    """Return the path of a preset or of a file; text without a folder or ``.toml`` is the name of a preset.

    Raises
    ------
    RequestError
        If it is the name of neither.
    """
    path = as_path(spec, "rolling")
    if isinstance(spec, Path) or path.suffix == ".toml" or _is_system(path) or path.name != spec:
        return path
    # the presets of the default model first: the other models need not be loaded then
    if spec in presets(registry.named(registry.DEFAULT)):
        return registry.named(registry.DEFAULT).presets / f"{spec}.toml"
    for model in registry.every():
        if spec in presets(model):
            return model.presets / f"{spec}.toml"
    if spec in system_presets():
        return _SYSTEMS / f"{spec}.toml"
    known = _every_preset()
    example = f"rolling {spec}" if "=" in spec else "rolling"
    from_atlas = f"Where a command goes on from an atlas, it is given with --from {shown(spec)}." * (
        path.suffix == ".nc"
    )
    raise RequestError(
        f"There is no preset {shown(spec) or 'without a name'}. A spec is a preset, a .toml file, or a .py file with a "
        f"system; presets are {', '.join(known)}.",
        hint=from_atlas
        or suggestion(spec, known)
        or f"Name a preset, as in {example}, or a file, as in my-sweep.toml.",
        where=shown(spec),
    )


def _is_system(path: Path) -> bool:
    """Return whether a path is of a file of systems, or of one system in it: ``mine.py:name``."""
    return path.suffix == ".py" or ".py:" in path.name


def place(path: Path) -> str:
    """Return what messages call a spec file: a preset by its name, any other by its path."""
    return f"preset {path.stem}" if path.parent.name == "presets" else str(path)


def read_file(path: Path) -> dict[str, object]:
    """Return the words in a TOML file, in their order.

    Raises
    ------
    RequestError
        If the file cannot be read or is not TOML.
    """
    import tomllib

    if _is_system(path):
        return {"model": str(path.absolute())}
    try:
        text = read_regular(path, _MOST_BYTES).decode("utf-8-sig")
        if any(part.count(".") > _MOST_DOTS for line in text.splitlines() for part in line.split(",")):
            raise RecursionError
        return tomllib.loads(text)
    except OSError as problem:
        raise RequestError(
            f"The spec file cannot be read: {problem.strerror or type(problem).__name__}. A spec is a .toml file, "
            f"a .py file with a system, or a preset: {', '.join(_every_preset())}.",
            hint="Check the path.",
            where=str(path),
        ) from problem
    # a TOML error with its line, text that is not UTF-8, or a number beyond any size
    except ValueError as problem:
        raise RequestError(
            f"The spec file is not TOML: {problem}. A spec file holds lines NAME = VALUE, text in quotes, as in "
            'tilt = "0.1deg:5deg:200:log".',
            hint="Correct that line.",
            where=str(path),
        ) from problem
    except RecursionError as problem:
        raise RequestError(
            "The spec file is no request: its arrays, tables or dotted names are nested too deep to be read. A spec "
            "file holds lines NAME = VALUE.",
            hint="Write lists as in alpha = [0.5, 1].",
            where=str(path),
        ) from problem


def kept_mass(spec: str | Path, changes: Mapping[str, object]) -> str:
    """Return that a file's mass stays that of its own disk where words change the radius; empty if it does not.

    Parameters
    ----------
    spec : str or Path
        A preset or a file.
    changes : mapping of str to anything
        The words that change it.
    """
    sizes = [name for name in ("radius", "diameter") if name in changes]
    if not sizes or "mass" in changes:
        return ""
    path = find_spec_file(spec)
    mass = read_file(path).get("mass")
    if mass is None:
        return ""
    return f"{place(path)}: with {sizes[0]}={changes[sizes[0]]} the mass is still {mass}; give another one as mass="


def read_regular(path: Path, most: int) -> bytes:
    """Return the content of a regular file of so many bytes at most; an OSError says that it is none, or too large.

    A pipe would be waited for without end, and a device read without end.
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "It is not a regular file")
    with open(path, "rb") as file:
        # what /proc shows as empty may have content
        content = b"" if found.st_size > most else file.read(most + 1)
    if max(found.st_size, len(content)) > most:
        raise OSError(
            errno.EFBIG, f"It has {max(found.st_size, len(content))} bytes or more, of at most {most}"
        )
    return content
