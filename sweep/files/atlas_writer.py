"""The netCDF file of an atlas, written from blocks of cells: netCDF declares it, its chunks are filtered in threads.

netCDF writes the small variables and declares those of the cells. Their chunks are filtered in several threads
(`sweep.files.raw_chunks`), and h5py, which can store what is filtered already, puts them into the same file. The two
libraries bring an HDF5 each, so the file is never open in both.
"""

import contextlib
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Seen, unseen
from sweep.atlas.cf_metadata import COMPRESSION, Declaration, cell_declarations
from sweep.atlas.dataset import boundaries, coordinates
from sweep.engine.compute import Block
from sweep.engine.grid import Span, chunk_shape, chunks
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.raw_chunks import RawChunks, packed
from sweep.model.description import Columns
from sweep.request.spec import SweepSpec

#: Returns all variables of the cells of a span from the columns that there are of them.
Completion = Callable[[Span, Columns], Columns]

#: Threads that filter, at most: one thread writes as much as about so many filter.
_MOST_THREADS = 16

#: Chunks that wait to be written beside those that are being filtered, 5 MB each.
_WAITING = 2


class _Chunk(NamedTuple):
    """A chunk of the cells' variables: its cells, its place in the grid, and its stored form for each variable."""

    block: Block
    slices: tuple[slice, ...]
    contents: list[bytes]


class AtlasWriter:
    """The netCDF file of an atlas while it is written: cells first, then the boundary.

    All methods have to be called in one thread, since neither netCDF nor HDF5 may be called in two.

    Parameters
    ----------
    path : Path
        A temporary name: until the boundary is written, the file is not complete.
    spec : SweepSpec
    attributes : mapping
        The global attributes.
    threads : int
        Threads that filter chunks, beside the one that writes them.

    Raises
    ------
    OSError, RuntimeError
        From every method: if the file system or netCDF refuses.
    """

    def __init__(
        self,
        path: Path,
        spec: SweepSpec,
        attributes: Mapping[str, Any],
        threads: int = 1,
    ) -> None:
        # absolute, because netCDF-C leaves out blanks at the begin of a name
        self._path, self.spec, self._threads = path.absolute(), spec, min(threads, _MOST_THREADS)
        self._cells = cell_declarations(spec)
        self._chunk = chunk_shape(spec.shape)
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
        """Write the variables with one value per cell chunk by chunk; yield the cells of each chunk that is written.

        The order of the chunks depends on the grid alone, and so do the bytes of the file.

        Parameters
        ----------
        blocks : iterable of Block
            All cells in C order.
        complete : callable
            Makes all variables of a chunk of what the blocks hold; called in several threads at once. If not given, the
            blocks hold all variables.
        """
        if not self.spec.axes:
            yield self._write_only_cell(blocks, complete)
            return

        def filtered(slices: tuple[slice, ...], block: Block) -> _Chunk:
            columns, cells = complete(block.span, block.columns), math.prod(self._chunk)
            contents = [packed(_filled(each, columns[each.name]), cells) for each in self._cells]
            return _Chunk(Block(block.span, columns), slices, contents)

        # not lists: 1e10 cells have 150,000 chunks
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
        """Find the boundary that the stored verdicts have, and write it, with the dimensions that only it has.

        `seen` is called now and then with the share of the search that is done, from 0 to 1.
        """
        with self._opened("a") as file:
            stability = file["stability"]
            stability.set_auto_maskandscale(False)
            verdicts = np.asarray(stability[...])
        # the search calls `seen`, which may read files of its own
        found = [*boundaries(self.spec, verdicts, seen)]
        with self._opened("a") as file:
            for declared, values in found:
                for name, count in zip(declared.dims, values.shape, strict=True):
                    if name not in file.dimensions:
                        file.createDimension(name, count)
                self._write_whole(file, declared, values)

    @contextlib.contextmanager
    def _opened(self, mode: Literal["w", "a"]) -> Iterator[Any]:
        # not at the top: a request that is refused before any file is opened need not wait for this import
        import netCDF4

        with netcdf_to_itself(), netCDF4.Dataset(self._path, mode, format="NETCDF4_CLASSIC") as file:
            yield file

    def _write_only_cell(self, blocks: Iterable[Block], complete: Completion) -> Block:
        """Write the cell of a grid without axes: netCDF stores single numbers as they are."""
        (given,) = blocks
        block = Block(given.span, complete(given.span, given.columns))
        with self._opened("a") as file:
            for each in self._cells:
                self._write_whole(file, each, block.columns[each.name].reshape(()))
        return block

    def _is_compressed(self, declared: Declaration) -> bool:
        """Whether a coordinate is as long as the cells are many: the numbers of a list of starts."""
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
    """Give what a function returns for each job, computed in threads, in the order of the jobs.

    Few more jobs are taken than there are threads: memory stays bounded.
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
    """Yield consecutive spans of cells, cut from consecutive blocks of the same cells."""
    stream, held = iter(blocks), list[Block]()
    for span in spans:
        while not held or held[-1].span.stop < span.stop:
            held.append(next(stream))
        cuts = [slice(max(0, span.start - each.span.start), span.stop - each.span.start) for each in held]
        parts = {
            name: [each.columns[name][cut] for each, cut in zip(held, cuts, strict=True)]
            for name in held[0].columns
        }
        # most spans lie in one block: its columns are not copied
        yield Block(
            span, {name: part[0] if len(part) == 1 else np.concatenate(part) for name, part in parts.items()}
        )
        held = [each for each in held if each.span.stop > span.stop]
