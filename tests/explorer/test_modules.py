"""The page's modules import each other by the names in the server's import map."""

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
    """Return the names of the modules that one imports, except type imports."""
    text = (PAGE / name).read_text(encoding="utf-8")
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    return set(re.findall(r"""\b(?:from|import)\s*\(?\s*["']([\w@./-]+)["']""", code))


def test_modules_import_names_of_the_map():
    """Modules use only names of the import map, because a single-file page has no folders."""
    for name in OWN:
        with case(name):
            assert imported(name) <= set(MAP)


def test_every_module_is_used():
    """Every module is imported by another one or is an entry point."""
    used = set().union(*(imported(name) for name in FILES))
    starts = set(re.findall(r'<script type="module" src="\./page/([^"]+)"', INDEX))
    # type modules have no code; workers are started by the addresses of their scripts
    names = ("kernels", "verdicts", "disk_cells", "path_cells", "system_cells", "worker")
    scripts = {f"eulerdisk/compute/{name}" for name in names}
    others = {"eulerdisk/types", *scripts}
    assert {name for path, name in FILES.items() if path not in starts} - others <= used


def test_page_has_no_inline_code():
    """The page has no inline script except its import map, and no inline handlers, as its policy requires."""
    scripts = re.findall(r"<script\b([^>]*)>(.*?)</script>", INDEX, re.DOTALL)
    assert all(body == "" for _, body in scripts)
    assert not re.search(r"\son\w+\s*=", INDEX)
    assert not re.search(r"https?://", INDEX)
