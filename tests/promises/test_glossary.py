"""The glossary, or a page that it links to for variables, names everything that is stored or asked for."""

import re
from pathlib import Path

from sweep.model.bodies import tables as bodies
from sweep.model.disk import tables as disk
from sweep.model.disk.path import PATH_VARIABLES
from sweep.model.lossy_disk import tables as lossy

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "glossary.md").read_text(encoding="utf-8")
#: The pages that describe variables and words: the first paragraph of the glossary links to them.
VARIABLES = ("atlas.md", "losses.md", "bodies.md")


def names():
    """Return what cells hold, how they end, and the words that describe a disk, its losses, and other bodies."""
    for each in (disk, lossy, bodies):
        yield from (
            *each.PARAMETERS,
            *each.OPTIONS,
            *each.VARIABLES,
            *(each.ENDINGS.quantity.flags or {}).values(),
        )
    yield from (
        *disk.SETTINGS,
        *lossy.SETTINGS,
        *disk.CONTACT_VARIABLES,
        *disk.REDUCTION,
        *PATH_VARIABLES,
    )


def test_the_pages_have_the_names():
    """Each is there as it is written in a file, or in plain words."""
    assert all(f"({page}" in PAGE.partition("\n## ")[0] for page in VARIABLES)
    text = "\n".join([PAGE, *((DOCS / page).read_text(encoding="utf-8") for page in VARIABLES)])
    lacking = [name for name in names() if not re.search(rf"\b{name}\b|\b{name.replace('_', ' ')}\b", text)]
    assert lacking == []


def test_every_entry_is_there_once():
    """No word is explained twice."""
    words = re.findall(r"^\*\*([^*]+)\*\*", PAGE, re.M)
    assert len(words) > 50
    assert len(set(words)) == len(words)
