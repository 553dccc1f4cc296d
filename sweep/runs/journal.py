"""The journal of a run: its finished blocks on disk, each an immutable file that knows when it is damaged.

A block is `blocks/000123-1a2b3c4d.npz`: an uncompressed NumPy archive of what `packing` stores of its columns, whose
members carry a checksum each. The name holds a checksum of all that surrounds the members' data, their checksums among
it, begun with the run's fingerprint and the block's cells. A file that was cut, zero-filled or altered, or belongs to
another run or another place, does not fit its name or its checksums; and no byte had to be summed twice.
"""

import contextlib
import io
import os
import platform
import struct
import threading
import zipfile
import zlib
from collections.abc import Generator, Iterable, Iterator
from pathlib import Path

import numpy as np

from sweep.engine.runner import Block, Columns
from sweep.errors import RequestError
from sweep.files.publish import publish
from sweep.runs import packing
from sweep.runs.locks import LOCK, OWNER
from sweep.runs.manifest import Manifest

#: Name of the folder beside the output.
SUFFIX = ".run"

MANIFEST = "manifest.json"

#: The file in the making, and the record of which file was made.
ASSEMBLED, PUBLISHED = "assembled.nc", "published.json"

#: All that a run makes in its folder, and in that of its blocks.
_NAMES = (MANIFEST, ASSEMBLED, PUBLISHED, LOCK, OWNER)
_KINDS = ("*.npz", "*.npz.damaged", "*.tmp")


class DamagedBlockError(Exception):
    """A block's file is not what was written."""


class Journal:
    """The finished blocks of a run.

    Parameters
    ----------
    folder : Path
        The run's folder; it exists.
    manifest : Manifest
    """

    def __init__(self, folder: Path, manifest: Manifest) -> None:
        self.folder = folder
        self.manifest = manifest
        self.spans = manifest.spans
        self._blocks = folder / "blocks"
        self._fingerprint = manifest.fingerprint

    @classmethod
    def at(cls, folder: Path) -> "Journal":
        """Return the journal in a folder.

        Raises
        ------
        RequestError
            If there is none, or its manifest is damaged.
        """
        try:
            return cls(folder, Manifest.read(folder / MANIFEST))
        except OSError as problem:
            raise RequestError(
                "not the folder of a run",
                f"a run's folder is called OUT.nc{SUFFIX} and holds {MANIFEST}",
                f"{problem.strerror}",
                "prepare one: eulerdisk prepare SPEC -o OUT.nc",
                str(folder),
            ) from problem

    def held(self) -> dict[int, list[Path]]:
        """Return the files of every block that has one, by number; more than one where machines disagreed."""
        found: dict[int, list[Path]] = {}
        with contextlib.suppress(FileNotFoundError):
            for path in sorted(self._blocks.glob("*.npz")):
                number = path.name.partition("-")[0]
                if number.isdecimal() and int(number) < len(self.spans):
                    found.setdefault(int(number), []).append(path)
        return found

    def missing(self, held: Iterable[int]) -> list[int]:
        """Return the numbers of the other blocks."""
        return sorted(set(range(len(self.spans))) - set(held))

    def kept(self) -> str:
        """Return how many blocks are finished, in words."""
        count = len(self.held())
        return (
            f"{count} of {len(self.spans)} blocks are kept in {self.folder}"
            if count
            else "no block was finished"
        )

    def keep(self, number: int, columns: Columns) -> None:
        """Write a finished block; when this returns, not even a power cut loses it.

        Raises
        ------
        OSError
            If the file system refuses; nothing of the block is left then.
        """
        stored = packing.packed(self.manifest.spec, columns)
        self._blocks.mkdir(exist_ok=True)
        who = f"{platform.node()}-{os.getpid()}-{threading.get_ident()}"
        unfinished = self._blocks / f"{number:06d}.{who}.tmp"
        try:
            with open(unfinished, "wb") as file:
                stream = _Summed(file, self._seed(number))
                # opened on a stream that cannot seek, zipfile never goes back: one pass, one checksum
                with zipfile.ZipFile(stream, "w") as archive:  # type: ignore[call-overload]  # writes only
                    for name, column in stored.items():
                        # a date of its own would make two files of the same block differ
                        with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as member, stream.unsummed():
                            np.lib.format.write_array_header_1_0(
                                member, np.lib.format.header_data_from_array_1_0(column)
                            )
                            member.write(np.ascontiguousarray(column).data)
            publish(unfinished, self._blocks / f"{number:06d}-{stream.sum:08x}.npz")
        finally:
            with contextlib.suppress(FileNotFoundError):
                unfinished.unlink()

    def read(self, number: int, path: Path) -> Block:
        """Return a block from its file.

        Raises
        ------
        DamagedBlockError
            If the file is not what was written.
        """
        span = self.spans[number]
        return Block(span, packing.unpacked(self.manifest.spec, span, self._stored(number, path)))

    def _stored(self, number: int, path: Path) -> packing.Stored:
        try:
            content = path.read_bytes()
            if path.stem.partition("-")[2] != f"{zlib.crc32(_surroundings(content), self._seed(number)):08x}":
                raise DamagedBlockError(f"{path.name} does not fit its checksum")
            with np.load(io.BytesIO(content), allow_pickle=False) as archive:
                return dict(archive)
        except (
            OSError,
            ValueError,
            NotImplementedError,
            RuntimeError,
            struct.error,
            zipfile.BadZipFile,
        ) as problem:
            raise DamagedBlockError(f"{path.name}: {problem}") from problem

    def verify(self, numbers: Iterable[int] | None = None) -> tuple[set[int], list[str]]:
        """Read blocks, all if not given; set aside what is damaged, and blocks of which there are two.

        Returns
        -------
        (sound, damaged) : set of int, list of str
            Numbers of the blocks that can be relied on; what is wrong with the others.
        """
        sound, damaged = set(), []
        held = self.held()
        for number in held if numbers is None else held.keys() & set(numbers):
            paths = held[number]
            try:
                if len(paths) > 1:
                    raise DamagedBlockError(f"block {number} was computed twice with different results")
                self._stored(number, paths[0])
                sound.add(number)
            except DamagedBlockError as problem:
                damaged.append(str(problem))
                for path in paths:
                    path.rename(path.with_name(path.name + ".damaged"))
        return sound, damaged

    def blocks(self) -> Generator[Block, None, None]:
        """Yield all blocks in order.

        Raises
        ------
        DamagedBlockError
            If one is missing or damaged.
        """
        held = self.held()
        for number in range(len(self.spans)):
            if len(held.get(number, ())) != 1:
                raise DamagedBlockError(f"block {number} has {len(held.get(number, ()))} files")
            yield self.read(number, held[number][0])

    def sweep_out(self) -> None:
        """Remove what a killed writer left half done. Only for who holds the lock alone."""
        for path in [*self._blocks.glob("*.tmp"), *self.folder.glob("*.tmp"), self.folder / ASSEMBLED]:
            with contextlib.suppress(FileNotFoundError):
                path.unlink()

    def _seed(self, number: int) -> int:
        span = self.spans[number]
        return zlib.crc32(f"{self._fingerprint} {number} {span.start} {span.stop}".encode("ascii"))


def remove(folder: Path) -> None:
    """Remove the folder of a run that is no longer needed; what somebody else has put there stays, and the folder too.

    The record of what was published goes last: until then, whoever comes after a crash knows that the file is there.
    """
    blocks = folder / "blocks"
    names = [folder / name for name in _NAMES if name != PUBLISHED]
    for path in (*(path for kind in _KINDS for path in blocks.glob(kind)), *names, *folder.glob("*.tmp")):
        with contextlib.suppress(OSError):
            path.unlink()
    with contextlib.suppress(OSError):
        blocks.rmdir()
    (folder / PUBLISHED).unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()


def strange(folder: Path) -> list[str]:
    """Return the names in a folder that no run makes."""
    # os.path, because a pathlib.Path raises where the name is too long
    if not os.path.isdir(folder):
        return []
    return sorted(
        name
        for name in os.listdir(folder)
        if name not in (*_NAMES, "blocks") and not name.endswith(".tmp") and not name.startswith(".")
    )


class _Summed:
    """A stream to write to that sums up what passes; it cannot seek."""

    def __init__(self, file: io.BufferedWriter, seed: int) -> None:
        self._file = file
        self._summing = True
        self.sum = seed

    @contextlib.contextmanager
    def unsummed(self) -> Iterator[None]:
        """Let pass what the archive itself sums up."""
        self._summing = False
        yield
        self._summing = True

    def write(self, data: bytes) -> int:
        """Write all of the data."""
        if self._summing:
            self.sum = zlib.crc32(data, self.sum)
        return self._file.write(data)

    def flush(self) -> None:
        """Nothing is held back here, and the file flushes itself when it is closed."""


def _surroundings(content: bytes) -> bytes:
    """Return an archive without the data of its members: headers, names, sizes, checksums."""
    parts, after = [], 0
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        for member in archive.infolist():
            # the lengths of name and extra field, which stand before the data, are bytes 26 to 29 of a local header
            name, extra = struct.unpack_from("<HH", content, member.header_offset + 26)
            start = member.header_offset + 30 + name + extra
            parts.append(content[after:start])
            after = start + member.compress_size
    return b"".join([*parts, content[after:]])
