"""The modules of the page: each imports others by the names that the server puts into its import map."""

import re
from pathlib import Path

from cases import case

from sweep.explorer.pages import modules, page_files

PAGE = Path(__file__).parents[2] / "sweep" / "explorer" / "page"
INDEX = (PAGE / "index.html").read_text(encoding="utf-8")
MAP = modules(page_files())
FILES = {path: name for name, path in MAP.items()}
OWN = sorted(
    path.relative_to(PAGE).as_posix()
    for path in PAGE.rglob("*.js")
    if "vendor" not in path.relative_to(PAGE).parts
)


def imported(name):
    """Return the names of the modules that one imports, except for those of types alone."""
    text = (PAGE / name).read_text(encoding="utf-8")
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    return set(re.findall(r"""\b(?:from|import)\s*\(?\s*["']([\w@./-]+)["']""", code))


def test_modules_import_names_of_the_map():
    """A module imports others by their names in the map alone: a page that is one file has no folders."""
    for name in OWN:
        with case(name):
            assert imported(name) <= set(MAP)


def test_every_module_is_used():
    """Every module is imported by another one, or is where the page begins."""
    used = set().union(*(imported(name) for name in FILES))
    starts = set(re.findall(r'<script type="module" src="\./page/([^"]+)"', INDEX))
    # types hold no code; a worker is begun by the addresses of its scripts
    names = ("kernels", "verdicts", "disk_cells", "path_cells", "system_cells", "worker")
    scripts = {f"eulerdisk/compute/{name}" for name in names}
    others = {"eulerdisk/types", *scripts}
    assert {name for path, name in FILES.items() if path not in starts} - others <= used


def test_page_has_no_inline_code():
    """The page's own text holds no script but its import map, and no handler: its policy would not run them."""
    scripts = re.findall(r"<script\b([^>]*)>(.*?)</script>", INDEX, re.DOTALL)
    assert all(body == "" for _, body in scripts)
    assert not re.search(r"\son\w+\s*=", INDEX)
    assert not re.search(r"https?://", INDEX)
