"""The journal of a run: its finished blocks on disk, each an immutable file that is complete or absent.

A block is `blocks/000123-1a2b3c4d.block`: one line of JSON with the name and type of each measured column, and the type
and number of its stored values; then these values, column after column. The name of the file ends in the CRC-32 of its
content, seeded with the fingerprint of the run and the number and cells of the block. The checksum detects a file that
was truncated, filled with zeros or altered, and a block of another run or position. It costs 4 ns per cell; the fastest
cells take a microsecond.

The journal is removed when the file of the atlas is complete, and every byte of it costs time. So a column that repeats
itself is stored up to its first repetition, and integers are stored with the smallest sufficient type: 63 bytes per
cell become 17 to 46.
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

#: Name of the folder for blocks in the folder of a run.
BLOCKS = "blocks"

#: Suffix of the file of a block, and second suffix of a block that was set aside.
BLOCK, DAMAGED = ".block", ".damaged"


#: Name of the file of a block, which may have been set aside. Other files in the folder are not touched.
BLOCK_NAME = re.compile(rf"([0-9]{{6,}})-[0-9a-f]{{8}}{re.escape(BLOCK)}({re.escape(DAMAGED)})?")


def _no_run(folder: Path, problem: OSError) -> RequestError:
    """Return the error for a path that is not the folder of a run: its run has ended, or it is the file of a run."""
    file = folder.with_name(folder.name.removesuffix(SUFFIX)) if folder.name else folder
    if file.is_file() and not folder.is_dir():
        run_folder = directory_of(file)
        if run_folder.is_dir():
            return RequestError(
                f"This is a file; the folder of its run is {run_folder}.",
                hint=f"Give the folder: {shlex.quote(str(run_folder))}.",
                where=str(folder),
            )
        return RequestError(
            f"This run is finished: its file {file} exists, and its folder was removed.",
            hint=f"Nothing is left to do; eulerdisk info {shlex.quote(str(file))} shows what is in it.",
            where=str(folder),
        )
    return RequestError(
        f"This is not the folder of a run, which is called OUT.nc.run and contains a readable {MANIFEST}: "
        f"{problem.strerror}.",
        hint="Make one with `eulerdisk prepare SPEC -o OUT.nc`.",
        where=str(folder),
    )


class DamagedBlockError(Exception):
    """The error of a block whose file is missing or was changed, or that has several files."""


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
        """Make the journal of a new run in an existing folder."""
        # before the manifest: writing the manifest syncs the folder to disk, including the name of this one
        (folder / BLOCKS).mkdir(exist_ok=True)
        if manifest.spec.starts:
            publish_bytes(folder / STARTS, manifest.spec.starts.to_bytes())
        manifest.write(folder / MANIFEST)
        return cls(folder, manifest)

    @classmethod
    def at(cls, folder: Path) -> "Journal":
        """Return the journal in a folder; raise a RequestError if there is none, or its manifest is damaged."""
        try:
            return cls(folder, Manifest.read(folder / MANIFEST))
        except OSError as problem:
            raise _no_run(folder, problem) from problem

    def held(self) -> dict[int, list[Path]]:
        """Return the files of all finished blocks, by number; a block has several files if its results differ."""
        files: dict[int, list[Path]] = {}
        # another process may end the run and remove the folder in the meantime
        with contextlib.suppress(FileNotFoundError):
            for path in sorted(self._blocks.glob(f"*{BLOCK}")):
                match = BLOCK_NAME.fullmatch(path.name)
                if match and int(match[1]) < len(self.spans):
                    files.setdefault(int(match[1]), []).append(path)
        return files

    def cells(self, numbers: Iterable[int]) -> int:
        """Return the number of cells of some blocks."""
        return sum(len(self.spans[number]) for number in numbers)

    def kept(self) -> str:
        """Return the number of finished blocks in words."""
        count = len(self.held())
        if not count:
            return "no block was finished"
        return f"{counted(count, 'block', len(self.spans))} {are(count)} kept in {self.folder}"

    def keep(self, number: int, measured: Columns) -> None:
        """Write a finished block, so that it survives a power cut.

        If the file system raises an OSError, no part of the block remains.
        """
        content = encode(measured, self.spec.shape[-1] if self.spec.axes else 1)
        publish_bytes(self._blocks / f"{number:06d}-{self._checksum(number, content)}{BLOCK}", content)

    def read(self, number: int, paths: Sequence[Path]) -> Columns:
        """Return the measured columns of a block from its file, bit for bit as they were given to `keep`.

        `paths` come from `held`. Raises a DamagedBlockError if there is no path or several, or if the file was changed.
        """
        return decode(self._checked(number, paths), len(self.spans[number]))

    def verify(
        self, numbers: Iterable[int], seen: Callable[[int], None] = lambda _: None
    ) -> tuple[list[int], list[str]]:
        """Read blocks, and set aside damaged blocks and blocks with two different results.

        `seen` is called after every block with the number of cells read so far. Returns the numbers of the blocks that
        are missing or were set aside, and the problems of the latter.
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
        """Yield the numbers and the measured columns of all blocks in order, from `read`."""
        held = self.held()
        for number in range(len(self.spans)):
            yield number, self.read(number, held.get(number, ()))

    def _checked(self, number: int, paths: Sequence[Path]) -> bytes:
        """Return the content of the file of a block, as from `encode`, after a check of its checksum."""
        if len(paths) > 1:
            raise DamagedBlockError(f"block {number} was computed twice with different results")
        if not paths:
            raise DamagedBlockError(f"block {number} is missing")
        path = paths[0]
        try:
            content = path.read_bytes()
        except OSError as problem:
            raise DamagedBlockError(f"{path.name}: {problem}") from problem
        if path.stem.partition("-")[2] != self._checksum(number, content):
            raise DamagedBlockError(f"{path.name} does not match its checksum")
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
        Number of cells in a row of the grid: a column with equal rows is stored for one row, a constant column for one
        cell.
    """
    stored = {name: _narrowed(_without_repeats(column, row)) for name, column in columns.items()}
    header = [
        (name, columns[name].dtype.str, column.dtype.str, column.size) for name, column in stored.items()
    ]
    values = (np.ascontiguousarray(column).data for column in stored.values())
    return b"".join([json.dumps(header).encode("ascii"), b"\n", *values])


def decode(content: bytes, cells: int) -> Columns:
    """Return the columns of a block with this many cells from the content of its file, as they were before `encode`."""
    start = content.index(b"\n") + 1
    columns: dict[str, npt.NDArray[Any]] = {}
    for name, kind, stored_kind, count in json.loads(content[:start]):
        stored = np.frombuffer(content, stored_kind, count, start)
        start += stored.nbytes
        # a copy, because the bytes of the file are not aligned; not np.resize, which would join `cells` arrays
        column = stored.astype(kind)
        columns[name] = column if count == cells else np.tile(column, -(-cells // count))[:cells]
    return columns


def _without_repeats(column: npt.NDArray[Any], row: int) -> npt.NDArray[Any]:
    # compare bits: NaN is not equal to itself, and 0 is equal to -0
    bits = column.view(f"u{column.itemsize}")
    for period in sorted({1, row}):
        if period >= bits.size:
            break
        # comparing the ends first excludes nearly all columns without repeats
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
