"""Points that are joined to at most two others each, followed from one to the next: chains and loops."""

import errno
from array import array
from collections.abc import Callable, Iterator

import numpy as np

from sweep.atlas.neighbours import ACROSS, DOWN, NOWHERE, Joined
from sweep.atlas.scratch import Column, Scratch

#: Points of a page, as a power of two, and pages that are held at a time: 105 MB.
_PAGE_BITS, _MOST_PAGES = 10, 4096

#: Points among which a start is looked for at a time, and which are followed before they are written.
_AT_ONCE = 2**16

#: The places of the points of a page, what each is joined to (before and after), and which have been passed.
_Page = tuple[memoryview, memoryview, memoryview, bytearray]


class Points:
    """The points of one kind, with their links; see `sweep.atlas.neighbours.Joined`."""

    def __init__(self, scratch: Scratch) -> None:
        self.places, self.before, self.after = (scratch.column("i8") for _ in range(3))
        self.passed = scratch.column("i1")

    def append(self, joined: Joined) -> None:
        """Add points and links."""
        self.places.append(joined.places)
        self.before.append(joined.before)
        self.after.append(joined.after)
        self.passed.append(np.zeros(joined.places.size, np.int8))

    def ends(self) -> Iterator[int]:
        """Yield the numbers of the points that are joined to one other at most."""
        for start in range(0, len(self.places), _AT_ONCE):
            before, after = (each.read(start, start + _AT_ONCE) for each in (self.before, self.after))
            yield from (start + np.flatnonzero((before == NOWHERE) | (after == NOWHERE))).tolist()


class Chains:
    """Follows all points, of which it holds some pages.

    Where two readings of the verdicts differ, links do not fit together, and a walk might never end: OSError is raised.

    Parameters
    ----------
    scratch : Scratch
    points : tuple of Points
        Those of both kinds; the first kind comes first in every order.
    seen : callable
        Called now and then.

    Attributes
    ----------
    places : Column
        The places of all points, chain after chain: the open ones first. Either sort is in the order of the points that
        they begin with: an open one with the first of its ends, a loop with the first of its points.
    counts, closed : Column
        How many points each chain has, and whether it is a loop.
    """

    def __init__(self, scratch: Scratch, points: tuple[Points, Points], seen: Callable[[], None]) -> None:
        self.places, self.counts, self.closed = (scratch.column(each) for each in ("i8", "i8", "i1"))
        self._points, self._seen = points, seen
        # by the number of the page and the kind; the one that was asked for last is the last
        self._pages: dict[int, _Page] = {}
        # what is to be appended to the columns
        self._found, self._lengths, self._loops = array("q"), array("q"), array("b")
        for kind in (DOWN, ACROSS):
            self._follow_open(kind)
        self._follow_loops()
        self._write()

    def _follow_open(self, kind: int) -> None:
        for number in self._points[kind].ends():
            passed = self._page(number >> _PAGE_BITS << 1 | kind)[3]
            if not passed[number & ((1 << _PAGE_BITS) - 1)]:
                self._follow(number << 1 | kind, NOWHERE, False)

    def _follow_loops(self) -> None:
        # the first point of a loop is of the first kind: a loop turns at both ends of its first line
        for page in range((len(self._points[DOWN].places) - 1 >> _PAGE_BITS) + 1):
            at = 0
            while (at := self._page(page << 1 | DOWN)[3].find(0, at)) >= 0:
                self._begin_loop(page, at)

    def _begin_loop(self, page: int, at: int) -> None:
        """Follow a loop from a point: backward, but not through a saddle if that can be avoided."""
        _, before, after, _ = self._page(page << 1 | DOWN)
        forward = before[at] & 1 and not after[at] & 1
        self._follow((page << _PAGE_BITS | at) << 1 | DOWN, before[at] >> 1 if forward else NOWHERE, True)

    def _follow(self, start: int, came: int, is_loop: bool) -> None:
        """Follow the points from one on, not toward the one that it came from, to an end or to the start."""
        here, held, found = start, -1, self._found
        began = len(self.places) + len(found)
        mask, bits = (1 << _PAGE_BITS) - 1, _PAGE_BITS + 1
        while True:
            key = here >> bits << 1 | here & 1
            if key != held:
                places, before, after, passed = self._page(key)
                held = key
            at = here >> 1 & mask
            if passed[at]:
                raise _unfit_links()
            passed[at] = 1
            found.append(places[at])
            if len(found) == _AT_ONCE:
                self._write()
            ahead = before[at] >> 1
            if ahead == came:
                ahead = after[at] >> 1
            if ahead in (NOWHERE, start):
                break
            here, came = ahead, here
        self._lengths.append(len(self.places) + len(found) - began)
        self._loops.append(is_loop)

    def _write(self) -> None:
        columns = (self.places, self.counts, self.closed)
        for column, found in zip(columns, (self._found, self._lengths, self._loops), strict=True):
            column.append(np.array(found))
            del found[:]
        self._seen()

    def _page(self, key: int) -> _Page:
        page = self._pages.pop(key, None)
        if page is None:
            if len(self._pages) == _MOST_PAGES:
                self._put_back(next(iter(self._pages)))
            page = self._read(key)
        self._pages[key] = page
        return page

    def _read(self, key: int) -> _Page:
        points, start = self._points[key & 1], key >> 1 << _PAGE_BITS
        columns = (points.places, points.before, points.after, points.passed)
        places, before, after, passed = (each.content(start, start + (1 << _PAGE_BITS)) for each in columns)
        return (
            memoryview(places).cast("q"),
            memoryview(before).cast("q"),
            memoryview(after).cast("q"),
            bytearray(passed),
        )

    def _put_back(self, key: int) -> None:
        passed: Column = self._points[key & 1].passed
        passed.replace(key >> 1 << _PAGE_BITS, self._pages.pop(key)[3])


def chains(scratch: Scratch, joined: Iterator[tuple[Joined, Joined]], seen: Callable[[], None]) -> Chains:
    """Take all points with their links, and follow them; `seen` is called now and then.

    Raises
    ------
    OSError
        If the file system refuses, or the links do not fit together.
    """
    points = (Points(scratch), Points(scratch))
    for parts in joined:
        for each, part in zip(points, parts, strict=True):
            each.append(part)
        seen()
    for each in points:
        if not len(each.places) == len(each.before) == len(each.after):
            raise _unfit_links()
    return Chains(scratch, points, seen)


def _unfit_links() -> OSError:
    return OSError(
        errno.EIO, "verdicts were not the same when they were read again; test the memory and the disk"
    )
