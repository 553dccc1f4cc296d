"""The glossary, or a page it links to, explains every stored variable and every input."""

import re
from pathlib import Path

from sweep.model.bodies import tables as bodies
from sweep.model.disk import tables as disk
from sweep.model.disk.path import PATH_VARIABLES
from sweep.model.lossy_disk import tables as lossy

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "glossary.md").read_text(encoding="utf-8")
#: Pages that describe variables and inputs; the first paragraph of the glossary links to them.
VARIABLES = ("atlas.md", "losses.md", "bodies.md")


def names():
    """Yield the names of cell values, endings, and the inputs for disks, losses and other bodies."""
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
    """Each name appears as written in a file, or in plain words."""
    assert all(f"({page}" in PAGE.partition("\n## ")[0] for page in VARIABLES)
    text = "\n".join([PAGE, *((DOCS / page).read_text(encoding="utf-8") for page in VARIABLES)])
    lacking = [name for name in names() if not re.search(rf"\b{name}\b|\b{name.replace('_', ' ')}\b", text)]
    assert lacking == []


def test_every_entry_is_there_once():
    """No word is explained twice."""
    words = re.findall(r"^\*\*([^*]+)\*\*", PAGE, re.M)
    assert len(words) > 50
    assert len(set(words)) == len(words)
