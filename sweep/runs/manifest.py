"""What a run is: its spec, its cut into blocks, and what its arithmetic is made of; written before the first block."""

import hashlib
import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Self

from sweep.engine import compiled
from sweep.engine.blocks import Span, blocks
from sweep.errors import RequestError, shown
from sweep.files.publish import publish_text
from sweep.request.spec import SweepSpec
from sweep.version import __version__

#: Version of the journal: names and contents of its files. 1 stored all columns whole.
FORMAT = 2

#: Packages whose versions decide the bits of a cell, and those that are recorded only.
_ARITHMETIC = ("numba", "llvmlite", "numpy")
_RECORDED = ("xarray", "netCDF4")


@dataclass(frozen=True)
class Manifest:
    """A run.

    Parameters
    ----------
    spec : SweepSpec
    block_cells : int
        Cells of a block.
    created : str
        When the run was begun, ISO 8601 in UTC: the time that the finished file bears.
    command : str
        What makes this atlas, for its history.
    arithmetic : mapping of str to str
        What decides the bits of a cell besides the spec: kernel hash, formats, versions.
    recorded : mapping of str to str
        Versions of what else was there.
    """

    spec: SweepSpec
    block_cells: int
    created: str
    command: str
    arithmetic: Mapping[str, str]
    recorded: Mapping[str, str]

    @classmethod
    def new(cls, spec: SweepSpec, block_cells: int, created: str, command: str) -> Self:
        """Return the manifest of a run that begins here and now."""
        recorded = {name: version(name) for name in _RECORDED}
        return cls(spec, block_cells, created, command, arithmetic(), recorded)

    @property
    def fingerprint(self) -> str:
        """SHA-256 over the spec and what else decides the bits; not over threads, blocks, time or command."""
        text = json.dumps([self.spec.canonical(), dict(self.arithmetic)], sort_keys=True)
        return hashlib.sha256(text.encode("ascii")).hexdigest()

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that the run uses, for the file."""
        return {name: self.arithmetic[name] for name in _ARITHMETIC} | dict(self.recorded)

    @property
    def spans(self) -> list[Span]:
        """The blocks in order."""
        return list(blocks(self.spec.size, self.block_cells))

    def differences(self, spec: SweepSpec) -> list[str]:
        """Return what keeps a request for `spec`, by this program, from being this run, field by field."""
        found = []
        for name in type(spec).model_fields:
            there, here = getattr(self.spec, name), getattr(spec, name)
            if there != here:
                found.append(f"{name}: {_text(there)} there, {_text(here)} here")
        for name, here in arithmetic().items():
            there = self.arithmetic.get(name)
            if there != here:
                found.append(f"{name}: {str(there)[:16]} there, {here[:16]} here")
        return found

    def write(self, path: Path) -> None:
        """Write the manifest; it is absent or whole.

        Raises
        ------
        OSError
        """
        content: dict[str, Any] = {
            "spec": json.loads(self.spec.canonical()),
            "block_cells": self.block_cells,
            "created": self.created,
            "command": self.command,
            "arithmetic": dict(self.arithmetic),
            "recorded": dict(self.recorded),
        }
        content["checksum"] = _checksum(content)
        publish_text(path, json.dumps(content, indent=1) + "\n")

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the manifest in a file.

        Raises
        ------
        RequestError
            If it is damaged, or of another program.
        FileNotFoundError
        """
        try:
            content = json.loads(path.read_text(encoding="ascii"))
            if content.pop("checksum") != _checksum(content):
                raise ValueError("the checksum does not fit")
            spec = SweepSpec.from_canonical(json.dumps(content.pop("spec"), sort_keys=True))
            return cls(spec, **content)
        except (ValueError, TypeError, KeyError, AttributeError, RequestError) as problem:
            raise RequestError(
                "the manifest of this run is damaged, or of another version of this program",
                "a manifest is as it was written",
                str(problem),
                f"use the version that began it, or start anew: {discard(path.parent)}",
                str(path),
            ) from problem


def discard(folder: Path) -> str:
    """Return the command that removes a run's folder, whatever characters its name has."""
    return f"`rm -r {shlex.quote(str(folder))}`"


def arithmetic() -> dict[str, str]:
    """Return what decides the bits of a cell in this process: kernel hash, format, versions."""
    return {
        "format": str(FORMAT),
        "eulerdisk": __version__,
        "kernel_hash": compiled.kernel_hash(),
        **{name: version(name) for name in _ARITHMETIC},
    }


def _checksum(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode("ascii")).hexdigest()


def _text(value: object) -> str:
    return shown(",".join(value) if isinstance(value, tuple) else str(value))
