"""Spec files and presets: finding and reading them."""

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

#: Largest size of a spec file in bytes, enough for a list of 50,000 values, and largest number of dots between two
#: commas or line ends: for a key of 20,000 parts the parser takes gigabytes.
_MOST_BYTES, _MOST_DOTS = 2**20, 50

#: The folder with presets of systems: for each a spec file, and the file of its system next to it.
_SYSTEMS = Path(sweep.model.system.__file__).with_name("presets")

#: The name of the tables that hold one sweep each, for `eulerdisk batch`, and its usual misspelling.
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
    """Return the path of the file with a preset's system."""
    return _SYSTEMS / f"{name}.py"


def _every_preset() -> tuple[str, ...]:
    """Return the names of all presets, with the default model's first and the systems' last."""
    return (*(name for model in registry.every() for name in presets(model)), *system_presets())


def find_spec_file(spec: str | Path) -> Path:
    """Return the path of a preset or a file; text without a folder and without ``.toml`` is a preset's name.

    Raises
    ------
    RequestError
        If there is no such preset.
    """
    path = as_path(spec, "rolling")
    if isinstance(spec, Path) or path.suffix == ".toml" or _is_system(path) or path.name != spec:
        return path
    # the default model's presets come first, which usually saves loading the other models
    if spec in presets(registry.named(registry.DEFAULT)):
        return registry.named(registry.DEFAULT).presets / f"{spec}.toml"
    for model in registry.every():
        if spec in presets(model):
            return model.presets / f"{spec}.toml"
    if spec in system_presets():
        return _SYSTEMS / f"{spec}.toml"
    known = _every_preset()
    example = f"rolling {spec}" if "=" in spec else "rolling"
    from_atlas = f"To continue from an atlas, write --from {shown(spec)}." * (path.suffix == ".nc")
    raise RequestError(
        f"There is no preset {shown(spec) or 'without a name'}. A spec is a preset, a .toml file, or a .py file with a "
        f"system; presets are {', '.join(known)}.",
        hint=from_atlas
        or suggestion(spec, known)
        or f"Name a preset, as in {example}, or a file, as in my-sweep.toml.",
        where=shown(spec),
    )


def _is_system(path: Path) -> bool:
    """Return whether a path names a file of systems, or one system in it: ``mine.py:name``."""
    return path.suffix == ".py" or ".py:" in path.name


def place(path: Path) -> str:
    """Return the name of a spec file in messages: a preset's name, otherwise the path."""
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
            f"The spec file is not TOML: {problem}. A spec file contains lines NAME = VALUE with text in quotes, as in "
            'tilt = "0.1deg:5deg:200:log".',
            hint="Correct that line.",
            where=str(path),
        ) from problem
    except RecursionError as problem:
        raise RequestError(
            "The spec file cannot be read: its arrays, tables or dotted names are nested too deeply. A spec file "
            "contains lines NAME = VALUE.",
            hint="Write lists as in alpha = [0.5, 1].",
            where=str(path),
        ) from problem


def kept_mass(spec: str | Path, changes: Mapping[str, object]) -> str:
    """Return a notice that the mass stays the same although words change the radius, or "" otherwise.

    Parameters
    ----------
    spec : str or Path
        A preset or a file.
    changes : mapping of str to anything
        The words that change the spec.
    """
    sizes = [name for name in ("radius", "diameter") if name in changes]
    if not sizes or "mass" in changes:
        return ""
    path = find_spec_file(spec)
    mass = read_file(path).get("mass")
    if mass is None:
        return ""
    return f"{place(path)}: with {sizes[0]}={changes[sizes[0]]} the mass is still {mass}; to change it, add mass="


def read_regular(path: Path, most: int) -> bytes:
    """Return the content of a regular file; raise OSError if it is not regular, or has more than `most` bytes.

    Reading a pipe could block forever, and reading a device might never end.
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "It is not a regular file")
    with open(path, "rb") as file:
        # files in /proc have size 0 and still have content
        content = b"" if found.st_size > most else file.read(most + 1)
    if max(found.st_size, len(content)) > most:
        raise OSError(
            errno.EFBIG, f"It has {max(found.st_size, len(content))} bytes or more, of at most {most}"
        )
    return content
