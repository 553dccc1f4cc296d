"""Links that do not fit together: what they give is an error, and no walk without an end."""

import numpy as np
import pytest

from sweep.atlas import chains
from sweep.atlas.neighbours import DOWN, NOWHERE, Joined, link_of
from sweep.atlas.scratch import Scratch

NONE = np.zeros(0, np.int64)

#: What each point is joined to, before and after.
CHAIN = (NOWHERE, 0, 1, 2), (1, 2, 3, NOWHERE)
LOOP = (3, 0, 1, 2), (1, 2, 3, 0)
#: From 0 to 1, and from there round and round.
TRAP = (NOWHERE, 2, 1, 2), (1, 0, 3, 1)
#: The same, beside no end.
LOOP_WITH_TRAP = (1, 2, 1, 2), (3, 0, 3, 1)


def followed(before, after):
    """Follow points of one kind with these links; fails where that takes far more steps than there are points."""
    left = iter(range(20))
    joined = Joined(np.arange(4), *(np.where(np.equal(each, NOWHERE), NOWHERE, link_of(np.array(each), DOWN))
        for each in (before, after)))  # fmt: skip
    with Scratch() as place:
        found = chains.chains(place, iter([(joined, Joined(NONE, NONE, NONE))]), lambda: next(left))
        return found.places.read(0, 9).tolist(), found.closed.read(0, 9).tolist()


@pytest.fixture(autouse=True)
def _often(monkeypatch):
    """Let it say after every point that it goes on."""
    monkeypatch.setattr(chains, "_AT_ONCE", 1)


@pytest.mark.parametrize(("links", "closed"), [(CHAIN, 0), (LOOP, 1)])
def test_links_that_fit(links, closed):
    """The points come in the order in which they are joined."""
    places, loops = followed(*links)
    assert places == ([0, 1, 2, 3] if not closed else [0, 3, 2, 1])
    assert loops == [closed]


@pytest.mark.parametrize("links", [TRAP, LOOP_WITH_TRAP])
def test_a_walk_does_not_come_by_a_point_twice(links):
    """It is told that verdicts have changed."""
    with pytest.raises(OSError, match="not the same when they were read again"):
        followed(*links)


@pytest.mark.parametrize("short", [0, 1])
def test_points_without_links(short):
    """Fewer links than points are told likewise."""
    links = [each[: 4 - (number == short)] for number, each in enumerate(CHAIN)]
    with pytest.raises(OSError, match="not the same when they were read again"):
        followed(*links)
