"""docs/figures.md names every option; tests/promises/test_pages.py runs its commands."""

import re
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
PAGE = (CHECKOUT / "docs" / "figures.md").read_text(encoding="utf-8")


def test_it_names_every_option(command):
    """The page has each option of the command and each keyword of `.plot`."""
    from sweep.accessor import Eulerdisk

    _, out, _ = command("plot --help")
    of_others = {"--plot", "--animate"}
    options = set(re.findall(r"--[a-z][a-z-]+", out)) - {"--help", "--output", "--regimes"} - of_others
    assert len(options) >= 10
    assert [option for option in options if f"`{option}`" not in PAGE] == []
    words = set(Eulerdisk.plot.__annotations__) - {"return"}
    assert [word for word in words if not re.search(rf"`{word}(=True)?`", PAGE)] == []
