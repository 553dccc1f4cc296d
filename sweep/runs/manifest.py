"""The manifest of a run: its spec, its cut into blocks, and what decides its bits; written before the first block."""

import hashlib
import json
import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Self

import numpy as np

from sweep import platforms
from sweep.atlas.cf_metadata import PACKAGES
from sweep.atomic import publish_bytes
from sweep.engine.compute import arithmetic_hash
from sweep.engine.grid import Span, blocks, starts_of
from sweep.errors import RequestError, shown
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.values import both_written
from sweep.runs.folder import STARTS

#: Cells at each end of the grid whose starts are compared.
_CELLS = 256

#: Settings with which processors of several kinds compute the same bits, set for every process that takes part. NumPy's
#: logarithm has a variant of its own for AVX-512.
SAME_BITS = (
    "NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= "
    "NPY_DISABLE_CPU_FEATURES='AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR'"
)


def machine_facts(spec: SweepSpec) -> dict[str, str]:
    """Return the kind of processor that kernels are compiled for, and the SHA-256 of the starts of a spec."""
    name, features = (os.environ.get(f"NUMBA_CPU_{each}", "") for each in ("NAME", "FEATURES"))
    return {"processor": f"{name or platforms.processor()} {features}".rstrip(), "starts": starts_hash(spec)}


def starts_hash(spec: SweepSpec) -> str:
    """Return the SHA-256 of the values of all axes, and of the completed starts of the first and last cells."""
    digest = hashlib.sha256()
    # the numbers of a list of starts are what they are everywhere
    for name in () if spec.is_list else spec.axes:
        axis = getattr(spec, name)
        assert isinstance(axis, Range | Values)
        for span in blocks(len(axis)):
            digest.update(axis.at(np.arange(span.start, span.stop)).tobytes())
    for span in (Span(0, min(spec.size, _CELLS)), Span(max(0, spec.size - _CELLS), spec.size)):
        for values in starts_of(spec, span).values():
            digest.update(np.asarray(values, np.float64).tobytes())
    return digest.hexdigest()


#: Version of the journal: names and contents of its files.
FORMAT = 1

#: Packages whose versions decide the bits of a cell, and those that are recorded only.
_ARITHMETIC = ("numba", "llvmlite", "numpy")
_RECORDED = tuple(name for name in PACKAGES if name not in _ARITHMETIC)


@dataclass(frozen=True)
class Manifest:
    """The spec of a run, its blocks, its origin, and what decides the bits of its cells."""

    spec: SweepSpec
    block_cells: int
    #: When the run was begun, ISO 8601 in UTC: the time that the finished file states.
    created: str
    #: The command that makes this atlas, for its history.
    command: str
    #: What decides the bits of a cell besides the spec: hash of the code, format of the journal, versions.
    arithmetic: Mapping[str, str]
    #: Versions of other packages.
    recorded: Mapping[str, str]
    #: SHA-256 over the spec and `arithmetic`, made when the run was begun. It seeds the checksum of every block.
    fingerprint: str
    #: What decides the bits on the machine that began the run (`sweep.runs.manifest`).
    machine: Mapping[str, str]

    @classmethod
    def new(cls, spec: SweepSpec, block_cells: int, created: str, command: str) -> Self:
        """Return the manifest of a run that is begun by this program on this machine."""
        deciding, here = arithmetic(spec), machine_facts(spec)
        recorded = {name: version(name) for name in _RECORDED}
        fingerprint = _digest([spec.canonical(), deciding, here])
        return cls(spec, block_cells, created, command, deciding, recorded, fingerprint, here)

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that the run uses, for the file."""
        return {name: self.arithmetic[name] for name in _ARITHMETIC} | dict(self.recorded)

    @property
    def spans(self) -> list[Span]:
        """The blocks in order."""
        return list(blocks(self.spec.size, self.block_cells))

    def differences(self, spec: SweepSpec) -> list[str]:
        """Return why this program cannot go on with this run for `spec`: one text for each field that differs.

        The fields are the words of the spec, and what decides the bits of the run's own cells.
        """
        there, here = (json.loads(each.canonical()) for each in (self.spec, spec))
        found = []
        for name in dict.fromkeys((*there, *here)):
            if there.get(name) != here.get(name):
                texts = both_written((self.spec, spec), name)
                found.append(f"{name}: {texts[0]} there, {texts[1]} here")
        for name, value in arithmetic(self.spec).items():
            before = self.arithmetic.get(name)
            if before != value:
                found.append(f"{name}: {str(before)[:16]} there, {value[:16]} here")
        return found

    def machine_differences(self) -> list[str]:
        """Return why this machine would compute other bits than the one that began the run, as `differences` does."""
        return [
            f"{name}: {self.machine.get(name, '')[:16]} there, {value[:16]} here"
            for name, value in machine_facts(self.spec).items()
            if self.machine.get(name) != value
        ]

    def write(self, path: Path) -> None:
        """Write the manifest; the file is absent or complete."""
        content = vars(self) | {"spec": json.loads(self.spec.canonical())}
        content["checksum"] = _digest(content)
        publish_bytes(path, (json.dumps(content, indent=1) + "\n").encode("ascii"))

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the manifest in a file, with the table of starts beside it if it has one.

        Raises
        ------
        RequestError
            If the manifest is damaged or of another version, or the table is damaged.
        """
        try:
            content = json.loads(path.read_text("ascii"))
            if content.pop("checksum") != _digest(content):
                raise ValueError("the checksum does not fit")
            spec = SweepSpec.from_canonical(json.dumps(content.pop("spec"), sort_keys=True))
            _check_types(content)
            manifest = cls(spec, **content)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, RequestError) as problem:
            raise RequestError(
                f"The manifest of this run is damaged, or of another version of this program: {problem}.",
                hint=f"Go on with the version that began the run, or start anew after {discard(path.parent)}.",
                where=str(path),
            ) from problem
        return replace(manifest, spec=_with_starts(spec, path.with_name(STARTS))) if spec.starts else manifest


def _check_types(content: Mapping[str, object]) -> None:
    """Raise ValueError for a field of a manifest that is not of its type."""
    for name, value in content.items():
        if name == "block_cells":
            fits = type(value) is int and value > 0
        elif name in ("arithmetic", "recorded", "machine"):
            fits = isinstance(value, dict) and all(isinstance(each, str) for each in value.values())
        else:
            fits = isinstance(value, str)
        if not fits:
            raise ValueError(f"{name} is {shown(value)}")


def _with_starts(spec: SweepSpec, path: Path) -> SweepSpec:
    """Return a spec with the values of its table, which are in the folder of the run."""
    try:
        return spec.replace(starts=spec.starts.from_bytes(path.read_bytes()))
    except (OSError, RequestError) as problem:
        reason = (
            problem.message if isinstance(problem, RequestError) else getattr(problem, "strerror", problem)
        )
        raise RequestError(
            f"The starts of this run cannot be taken from this file: {str(reason).rstrip('.')}.",
            hint=f"Put an undamaged copy of it there, or start anew after {discard(path.parent)}.",
            where=str(path),
        ) from problem


def discard(folder: Path) -> str:
    """Return the shell command that removes a run's folder; its name may have any characters."""
    return f"`rm -r {shlex.quote(str(folder))}`"


def arithmetic(spec: SweepSpec) -> dict[str, str]:
    """Return what decides the bits of the cells of a spec in this process: hash of the code, formats, versions."""
    return {
        "format": str(FORMAT),
        "arithmetic_hash": arithmetic_hash(spec),
        **{name: version(name) for name in _ARITHMETIC},
    }


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode("ascii")).hexdigest()
