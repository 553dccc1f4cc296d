"""The manifest of a run: its spec, its blocks, and everything that determines its bits; written before any block."""

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

#: Number of cells at each end of the grid whose starts are compared.
_CELLS = 256

#: Environment variables with which processors of different kinds compute the same bits, needed by all processes of a
#: run. NumPy's logarithm has another implementation for AVX-512.
SAME_BITS = (
    "NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= "
    "NPY_DISABLE_CPU_FEATURES='AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR'"
)


def machine_facts(spec: SweepSpec) -> dict[str, str]:
    """Return the kind of processor that kernels are compiled for, and the SHA-256 of the starts of a spec."""
    name, features = (os.environ.get(f"NUMBA_CPU_{setting}", "") for setting in ("NAME", "FEATURES"))
    return {"processor": f"{name or platforms.processor()} {features}".rstrip(), "starts": starts_hash(spec)}


def starts_hash(spec: SweepSpec) -> str:
    """Return the SHA-256 of the values of all axes, and of the completed starts of the first and last cells."""
    digest = hashlib.sha256()
    # the axis of a list of starts has only integers, the same on all machines
    for name in () if spec.is_list else spec.axes:
        axis = getattr(spec, name)
        assert isinstance(axis, Range | Values)
        for span in blocks(len(axis)):
            digest.update(axis.at(np.arange(span.start, span.stop)).tobytes())
    for span in (Span(0, min(spec.size, _CELLS)), Span(max(0, spec.size - _CELLS), spec.size)):
        for values in starts_of(spec, span).values():
            digest.update(np.asarray(values, np.float64).tobytes())
    return digest.hexdigest()


#: Version of the journal format: names and contents of its files.
FORMAT = 1

#: Packages whose versions affect the bits of a cell, and packages whose versions are only recorded.
_ARITHMETIC = ("numba", "llvmlite", "numpy")
_RECORDED = tuple(name for name in PACKAGES if name not in _ARITHMETIC)


@dataclass(frozen=True)
class Manifest:
    """The spec of a run, its blocks, its origin, and everything that determines the bits of its cells."""

    spec: SweepSpec
    block_cells: int
    #: When the run was begun, ISO 8601 in UTC: the creation time in the finished file.
    created: str
    #: The command that makes this atlas, for its history.
    command: str
    #: What determines the bits of a cell besides the spec: hash of the code, format of the journal, versions.
    arithmetic: Mapping[str, str]
    #: Versions of other packages.
    recorded: Mapping[str, str]
    #: SHA-256 over the spec, `arithmetic` and `machine` at the start of the run. It seeds the checksums of blocks.
    fingerprint: str
    #: What determines the bits on the machine that began the run (`machine_facts`).
    machine: Mapping[str, str]

    @classmethod
    def new(cls, spec: SweepSpec, block_cells: int, created: str, command: str) -> Self:
        """Return the manifest of a new run by this program on this machine."""
        code, machine = arithmetic(spec), machine_facts(spec)
        recorded = {name: version(name) for name in _RECORDED}
        fingerprint = _digest([spec.canonical(), code, machine])
        return cls(spec, block_cells, created, command, code, recorded, fingerprint, machine)

    @property
    def versions(self) -> dict[str, str]:
        """The versions of the packages that the run uses, for the file."""
        return {name: self.arithmetic[name] for name in _ARITHMETIC} | dict(self.recorded)

    @property
    def spans(self) -> list[Span]:
        """The blocks in order."""
        return list(blocks(self.spec.size, self.block_cells))

    def differences(self, spec: SweepSpec) -> list[str]:
        """Return why this program cannot resume this run for `spec`: one text for each field that differs.

        The fields are the words of the spec, and everything else that determines the bits of the run's cells.
        """
        before, now = (json.loads(each.canonical()) for each in (self.spec, spec))
        texts = []
        for name in dict.fromkeys((*before, *now)):
            if before.get(name) != now.get(name):
                old, new = both_written((self.spec, spec), name)
                texts.append(f"{name}: {old} in the run, {new} now")
        for name, value in arithmetic(self.spec).items():
            of_run = self.arithmetic.get(name)
            if of_run != value:
                texts.append(f"{name}: {str(of_run)[:16]} in the run, {value[:16]} now")
        return texts

    def machine_differences(self) -> list[str]:
        """Return why this machine may compute other bits than the one that began the run, as texts."""
        return [
            f"{name}: {self.machine.get(name, '')[:16]} in the run, {value[:16]} now"
            for name, value in machine_facts(self.spec).items()
            if self.machine.get(name) != value
        ]

    def write(self, path: Path) -> None:
        """Write the manifest; the file is absent or complete."""
        content = vars(self) | {
            "spec": json.loads(self.spec.canonical()),
            "requested": dict(self.spec.requested),
        }
        content["checksum"] = _digest(content)
        publish_bytes(path, (json.dumps(content, indent=1) + "\n").encode("ascii"))

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the manifest in a file, with the table of starts in the same folder if it has one.

        Raises
        ------
        RequestError
            If the manifest is damaged or from another version, or the table is damaged.
        """
        try:
            content = json.loads(path.read_text("ascii"))
            if content.pop("checksum") != _digest(content):
                raise ValueError("the checksum does not match")
            text = json.dumps(content.pop("spec"), sort_keys=True)
            _check_types(content)
            spec = SweepSpec.from_canonical(text, content.pop("requested"))
            manifest = cls(spec, **content)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, RequestError) as problem:
            raise RequestError(
                f"The manifest of this run is damaged, or from another version of this program: {problem}.",
                hint=f"Resume with the version that began the run, or start again after {discard(path.parent)}.",
                where=str(path),
            ) from problem
        return replace(manifest, spec=_with_starts(spec, path.with_name(STARTS))) if spec.starts else manifest


def _check_types(content: Mapping[str, object]) -> None:
    """Raise ValueError if a field of a manifest has the wrong type."""
    for name, value in content.items():
        if name == "block_cells":
            fits = type(value) is int and value > 0
        elif name in ("arithmetic", "recorded", "machine", "requested"):
            fits = isinstance(value, dict) and all(isinstance(text, str) for text in value.values())
        else:
            fits = isinstance(value, str)
        if not fits:
            raise ValueError(f"{name} is {shown(value)}")


def _with_starts(spec: SweepSpec, path: Path) -> SweepSpec:
    """Return a spec with the values of its table, from a file in the folder of the run."""
    try:
        starts = spec.starts.from_bytes(path.read_bytes())
        return SweepSpec.from_canonical(spec.canonical(), spec.requested, starts)
    except (OSError, RequestError) as problem:
        reason = problem.message if isinstance(problem, RequestError) else f"{problem.strerror}."
        raise RequestError(
            f"The starts of this run cannot be read from this file: {reason}",
            hint=f"Replace it with an undamaged copy, or start again after {discard(path.parent)}.",
            where=str(path),
        ) from problem


def discard(folder: Path) -> str:
    """Return the shell command that removes the folder of a run, with any name."""
    return f"`rm -r {shlex.quote(str(folder))}`"


def arithmetic(spec: SweepSpec) -> dict[str, str]:
    """Return what determines the bits of the cells of a spec in this process: hash of the code, format, versions."""
    return {
        "format": str(FORMAT),
        "arithmetic_hash": arithmetic_hash(spec),
        **{name: version(name) for name in _ARITHMETIC},
    }


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode("ascii")).hexdigest()
