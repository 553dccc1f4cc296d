"""The journal of a run: its finished blocks on disk, each an immutable file that is complete or not there.

A block is `blocks/000123-1a2b3c4d.block`: one line of JSON, which lists for each measured column its name, its type,
and the type and number of the values that are stored of it; then these values, column after column. The name of the
file ends in the CRC-32 of its content, seeded with the fingerprint of the run and the number and cells of the block:
the checksum detects a file that was truncated, filled with zeros or altered, and a block of another run or place. It
takes 4 ns of the microsecond that the fastest cells take.

The journal is removed when the file of the atlas is complete, and every byte of it costs time. So a column that repeats
itself is stored up to its first repetition, and integers have the smallest type that holds them: 63 bytes of a cell
become 17 to 46.
"""

import contextlib
import json
import re
import shlex
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from isal.isal_zlib import crc32

from sweep.atomic import publish_bytes, rename_aside
from sweep.errors import RequestError, are, counted
from sweep.runs.folder import MANIFEST, STARTS, SUFFIX, directory_of
from sweep.runs.manifest import Manifest

#: The measured columns of a block: name -> array with one value per cell.
Columns = Mapping[str, npt.NDArray[Any]]

#: Name of the folder of the blocks in that of the run.
BLOCKS = "blocks"

#: End of the name of a block, and what is appended to it when the block is set aside.
BLOCK, DAMAGED = ".block", ".damaged"


#: Whole name of the file of a block, also when it is set aside. Other files in the folder are not touched.
BLOCK_NAME = re.compile(rf"([0-9]{{6,}})-[0-9a-f]{{8}}{re.escape(BLOCK)}({re.escape(DAMAGED)})?")


def _no_run(folder: Path, problem: OSError) -> RequestError:
    """Return the error of what is no folder of a run: the run has ended, or its file was named in place of it."""
    ended = folder.with_name(folder.name.removesuffix(SUFFIX)) if folder.name else folder
    if ended.is_file() and not folder.is_dir():
        beside = directory_of(ended)
        if beside.is_dir():
            return RequestError(
                f"This is a file, and the folder of its run is {beside}.",
                hint=f"Give the folder: {shlex.quote(str(beside))}.",
                where=str(folder),
            )
        return RequestError(
            f"There is no run to go on with: its file {ended} is there, and the folder of a run goes when its file is "
            "whole.",
            hint=f"Nothing is left to do; eulerdisk info {shlex.quote(str(ended))} tells what is in it.",
            where=str(folder),
        )
    return RequestError(
        f"This is not the folder of a run, which is called OUT.nc.run and holds a readable {MANIFEST}: "
        f"{problem.strerror}.",
        hint="Make one with `eulerdisk prepare SPEC -o OUT.nc`.",
        where=str(folder),
    )


class DamagedBlockError(Exception):
    """The file of a block is not what was written."""


class Journal:
    """The finished blocks of a run in its folder."""

    def __init__(self, folder: Path, manifest: Manifest) -> None:
        self.folder = folder
        self.manifest = manifest
        self.spec = manifest.spec
        self.spans = manifest.spans
        self._blocks = folder / BLOCKS

    @classmethod
    def create(cls, folder: Path, manifest: Manifest) -> "Journal":
        """Make the journal of a new run in a folder that exists."""
        # before the manifest: writing the manifest synchronises the folder, and with it the name of this one
        (folder / BLOCKS).mkdir(exist_ok=True)
        if manifest.spec.starts:
            publish_bytes(folder / STARTS, manifest.spec.starts.to_bytes())
        manifest.write(folder / MANIFEST)
        return cls(folder, manifest)

    @classmethod
    def at(cls, folder: Path) -> "Journal":
        """Return the journal in a folder; a RequestError says that there is none, or that its manifest is damaged."""
        try:
            return cls(folder, Manifest.read(folder / MANIFEST))
        except OSError as problem:
            raise _no_run(folder, problem) from problem

    def held(self) -> dict[int, list[Path]]:
        """Return the files of every block that has one, by number; more than one where two results differ."""
        found: dict[int, list[Path]] = {}
        # another process may end the run and remove the folder while its names are read
        with contextlib.suppress(FileNotFoundError):
            for path in sorted(self._blocks.glob(f"*{BLOCK}")):
                named = BLOCK_NAME.fullmatch(path.name)
                if named and int(named[1]) < len(self.spans):
                    found.setdefault(int(named[1]), []).append(path)
        return found

    def cells(self, numbers: Iterable[int]) -> int:
        """Return how many cells some blocks have."""
        return sum(len(self.spans[number]) for number in numbers)

    def kept(self) -> str:
        """Return how many blocks are finished, in words."""
        count = len(self.held())
        if not count:
            return "no block was finished"
        return f"{counted(count, 'block', len(self.spans))} {are(count)} kept in {self.folder}"

    def keep(self, number: int, measured: Columns) -> None:
        """Write a finished block; after this has returned, the block survives a power cut.

        If the file system raises an OSError, nothing of the block is left.
        """
        content = encode(measured, self.spec.shape[-1] if self.spec.axes else 1)
        publish_bytes(self._blocks / f"{number:06d}-{self._checksum(number, content)}{BLOCK}", content)

    def read(self, number: int, paths: Sequence[Path]) -> Columns:
        """Return the measured columns of a block from its file, bit for bit as they were given to `keep`.

        `paths` are those of `held`. A DamagedBlockError says that there are none or several, or that the file is not
        what was written.
        """
        return decode(self._checked(number, paths), len(self.spans[number]))

    def verify(
        self, numbers: Iterable[int], seen: Callable[[int], None] = lambda _: None
    ) -> tuple[list[int], list[str]]:
        """Read blocks, and set aside those that are damaged, and those with two different results.

        `seen` is called with the number of cells that were looked at, after every block. Returns the numbers of the
        blocks that are not there or were set aside, and what is wrong with the latter.
        """
        missing, damaged, cells = [], [], 0
        held = self.held()
        for number in numbers:
            paths = held.get(number, [])
            try:
                self._checked(number, paths)
            except DamagedBlockError as problem:
                missing.append(number)
                if paths:
                    damaged.append(str(problem))
                for path in paths:
                    rename_aside(path, DAMAGED)
            cells += len(self.spans[number])
            seen(cells)
        return missing, damaged

    def blocks(self) -> Generator[tuple[int, Columns]]:
        """Yield the numbers and the measured columns of all blocks in order, by `read`."""
        held = self.held()
        for number in range(len(self.spans)):
            yield number, self.read(number, held.get(number, ()))

    def _checked(self, number: int, paths: Sequence[Path]) -> bytes:
        """Return the content of the file of a block, which `encode` has made: it fits its checksum."""
        if len(paths) > 1:
            raise DamagedBlockError(f"block {number} was computed twice with different results")
        if not paths:
            raise DamagedBlockError(f"block {number} is not there")
        path = paths[0]
        try:
            content = path.read_bytes()
        except OSError as problem:
            raise DamagedBlockError(f"{path.name}: {problem}") from problem
        if path.stem.partition("-")[2] != self._checksum(number, content):
            raise DamagedBlockError(f"{path.name} does not fit its checksum")
        return content

    def _checksum(self, number: int, content: bytes) -> str:
        span = self.spans[number]
        place = f"{self.manifest.fingerprint} {number} {span.start} {span.stop}"
        return f"{crc32(content, crc32(place.encode('ascii'))):08x}"


def encode(columns: Columns, row: int) -> bytes:
    """Return the content of the file of a block.

    Parameters
    ----------
    columns : mapping of str to array, shape (n,)
    row : int
        Cells of a row of the grid: a column that is the same in every row is stored for one row, a constant column for
        one cell.
    """
    stored = {name: _narrowed(_without_repeats(column, row)) for name, column in columns.items()}
    header = [
        (name, columns[name].dtype.str, column.dtype.str, column.size) for name, column in stored.items()
    ]
    values = (np.ascontiguousarray(each).data for each in stored.values())
    return b"".join([json.dumps(header).encode("ascii"), b"\n", *values])


def decode(content: bytes, cells: int) -> Columns:
    """Return the columns of a block of so many cells from the content of its file, as they were given to `encode`."""
    start = content.index(b"\n") + 1
    columns: dict[str, npt.NDArray[Any]] = {}
    for name, kind, stored_kind, count in json.loads(content[:start]):
        stored = np.frombuffer(content, stored_kind, count, start)
        start += stored.nbytes
        # a copy: the bytes of the file are not aligned. Not np.resize, which would join `cells` arrays
        column = stored.astype(kind)
        columns[name] = column if count == cells else np.tile(column, -(-cells // count))[:cells]
    return columns


def _without_repeats(column: npt.NDArray[Any], row: int) -> npt.NDArray[Any]:
    # bits, not values: NaN is not equal to itself, and 0 is equal to -0
    bits = column.view(f"u{column.itemsize}")
    for period in sorted({1, row}):
        if period >= bits.size:
            break
        # Comparing only the ends excludes nearly all columns without repeats.
        if (
            bits[period] == bits[0]
            and bits[-1] == bits[-1 - period]
            and np.array_equal(bits[period:], bits[:-period])
        ):
            return column[:period]
    return column


def _narrowed(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if column.dtype.kind != "i" or column.itemsize == 1:
        return column
    ends = (np.min_scalar_type(column.min()), np.min_scalar_type(column.max()))
    return column.astype(np.result_type(*ends), copy=False)
