"""The netCDF file of an atlas, written from blocks of cells whose chunks are filtered in several threads.

netCDF writes the small variables and declares the cell variables. Several threads filter the chunks of the cell
variables (`sweep.files.raw_chunks`), and h5py, which can store filtered chunks, writes them to the same file. Each
library has its own HDF5, so the file is never open in both.
"""

import contextlib
import errno
import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from sweep import platforms
from sweep.atlas.boundary import Seen, unseen
from sweep.atlas.cf_metadata import COMPRESSION, Declaration, cell_declarations
from sweep.atlas.dataset import boundaries, coordinates
from sweep.engine.compute import Block
from sweep.engine.grid import Span, chunk_shape, chunks
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.raw_chunks import RawChunks, packed
from sweep.model.description import Columns
from sweep.request.spec import SweepSpec

#: Returns all cell variables of a span from the columns available.
Completion = Callable[[Span, Columns], Columns]

#: Largest number of filtering threads: about this many keep the one writing thread busy.
_MOST_THREADS = 16

#: Least limit on the size of a file [bytes]: its descriptions alone are larger.
_LEAST_FILE = 2**14

#: Chunks waiting to be written, in addition to those being filtered; 5 MB each.
_WAITING = 2


class _Chunk(NamedTuple):
    """A chunk of the cell variables: its cells, its place in the grid, and its stored form for each variable."""

    block: Block
    slices: tuple[slice, ...]
    contents: list[bytes]


class AtlasWriter:
    """The netCDF file of an atlas while it is written: cells first, then the boundary.

    All methods must be called in the same thread, because netCDF and HDF5 are not thread-safe.

    Parameters
    ----------
    path : Path
        A temporary name: the file is incomplete until the boundary is written.
    spec : SweepSpec
    attributes : mapping
        The global attributes.
    threads : int
        Number of threads that filter chunks, in addition to the one that writes them.

    Raises
    ------
    OSError, RuntimeError
        From every method, if the file system or netCDF fails.
    """

    def __init__(
        self,
        path: Path,
        spec: SweepSpec,
        attributes: Mapping[str, Any],
        threads: int = 1,
    ) -> None:
        # absolute, because netCDF-C drops blanks at the start of a name
        self._path, self.spec, self._threads = path.absolute(), spec, min(threads, _MOST_THREADS)
        self._cells = cell_declarations(spec)
        self._chunk = chunk_shape(spec.shape)
        if platforms.file_size() < _LEAST_FILE:
            # HDF5 crashes at some limits that its descriptions do not fit into
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        with self._opened("w") as file:
            file.setncatts(dict(attributes))
            for name, count in zip(spec.axes, spec.shape, strict=True):
                file.createDimension(name, count)
            for declared, values in coordinates(spec):
                self._write_whole(file, declared, values)
            if spec.axes:
                for declared in self._cells:
                    self._declare(file, declared, self._chunk)

    def write_cells(
        self, blocks: Iterable[Block], complete: Completion = lambda _, columns: columns
    ) -> Iterator[Block]:
        """Write the cell variables chunk by chunk; yield the cells of each chunk once it is written.

        The order of the chunks depends only on the grid, so the bytes of the file do not depend on the threads.

        Parameters
        ----------
        blocks : iterable of Block
            All cells in C order.
        complete : callable
            Computes all variables of a chunk from the columns of the blocks; called in several threads at once. If not
            given, the blocks must have all variables.
        """
        if not self.spec.axes:
            yield self._write_only_cell(blocks, complete)
            return

        def filtered(slices: tuple[slice, ...], block: Block) -> _Chunk:
            columns, cells = complete(block.span, block.columns), math.prod(self._chunk)
            contents = [packed(_filled(each, columns[each.name]), cells) for each in self._cells]
            return _Chunk(Block(block.span, columns), slices, contents)

        # generators, not lists: 1e10 cells have 150,000 chunks
        places = (slices for _, slices in chunks(self.spec.shape))
        spans = (span for span, _ in chunks(self.spec.shape))
        jobs = zip(places, regroup(blocks, spans), strict=True)
        with RawChunks(self._path) as file, _in_order(filtered, jobs, self._threads) as filtered_chunks:
            for chunk in filtered_chunks:
                offset = tuple(part.start for part in chunk.slices)
                for each, content in zip(self._cells, chunk.contents, strict=True):
                    file.write(each.name, offset, content)
                yield chunk.block

    def write_boundary(self, seen: Seen = unseen) -> None:
        """Find the boundary in the stored verdicts, and write it with its dimensions.

        `seen` is called from time to time with the finished share of the search, from 0 to 1.
        """
        with self._opened("a") as file:
            stability = file["stability"]
            stability.set_auto_maskandscale(False)
            verdicts = np.asarray(stability[...])
        # the file is closed here, because the search calls `seen`, which may read other files
        found = [*boundaries(self.spec, verdicts, seen)]
        with self._opened("a") as file:
            for declared, values in found:
                for name, count in zip(declared.dims, values.shape, strict=True):
                    if name not in file.dimensions:
                        file.createDimension(name, count)
                self._write_whole(file, declared, values)

    @contextlib.contextmanager
    def _opened(self, mode: Literal["w", "a"]) -> Iterator[Any]:
        # not at the top, so that a request refused before any file is opened does not wait for this import
        import netCDF4

        with netcdf_to_itself(), netCDF4.Dataset(self._path, mode, format="NETCDF4_CLASSIC") as file:
            yield file

    def _write_only_cell(self, blocks: Iterable[Block], complete: Completion) -> Block:
        """Write the cell of a grid without axes: netCDF stores scalars without chunks."""
        (given,) = blocks
        block = Block(given.span, complete(given.span, given.columns))
        with self._opened("a") as file:
            for each in self._cells:
                self._write_whole(file, each, block.columns[each.name].reshape(()))
        return block

    def _is_compressed(self, declared: Declaration) -> bool:
        """Return whether a coordinate is as long as the list of starts, and should be compressed."""
        return self.spec.is_list and declared.dims == self.spec.axes

    def _write_whole(self, file: Any, declared: Declaration, values: npt.NDArray[Any]) -> None:
        variable = self._declare(file, declared, self._chunk if self._is_compressed(declared) else ())
        variable[...] = np.asarray(_filled(declared, values), declared.dtype)

    def _declare(self, file: Any, declared: Declaration, chunk: tuple[int, ...] = ()) -> Any:
        packed: dict[str, Any] = {}
        if chunk:
            packed = {"zlib": True, "complevel": COMPRESSION, "shuffle": True, "chunksizes": chunk}
        variable = file.createVariable(
            declared.name, declared.dtype, declared.dims, fill_value=declared.fill, **packed
        )
        variable.set_auto_maskandscale(False)
        variable.setncatts(declared.attributes)
        return variable


def _filled(declared: Declaration, values: Any) -> Any:
    if declared.fill is None:
        return values
    missing = np.isnan(values)
    return np.where(missing, declared.fill, values) if missing.any() else values


@contextlib.contextmanager
def _in_order[S, T](
    function: Callable[[S, T], _Chunk], jobs: Iterable[tuple[S, T]], threads: int
) -> Iterator[Iterator[_Chunk]]:
    """Yield an iterator over the results of a function for each job, computed in threads, in the order of the jobs.

    Only a few more jobs than threads are started at a time, which bounds the memory.
    """
    pool = ThreadPoolExecutor(threads)

    def results() -> Iterator[_Chunk]:
        waiting = deque[Future[_Chunk]]()
        for job in jobs:
            waiting.append(pool.submit(function, *job))
            while waiting and (waiting[0].done() or len(waiting) >= threads + _WAITING):
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()

    try:
        yield results()
    finally:
        pool.shutdown(cancel_futures=True)


def regroup(blocks: Iterable[Block], spans: Iterable[Span]) -> Iterator[Block]:
    """Yield the cells in the given consecutive spans, cut from consecutive blocks of the same cells."""
    stream, held = iter(blocks), list[Block]()
    for span in spans:
        while not held or held[-1].span.stop < span.stop:
            held.append(next(stream))
        cuts = [slice(max(0, span.start - each.span.start), span.stop - each.span.start) for each in held]
        parts = {
            name: [each.columns[name][cut] for each, cut in zip(held, cuts, strict=True)]
            for name in held[0].columns
        }
        # most spans lie in one block, whose columns are not copied
        yield Block(
            span, {name: part[0] if len(part) == 1 else np.concatenate(part) for name, part in parts.items()}
        )
        held = [each for each in held if each.span.stop > span.stop]
