"""The documentation is built without a warning, reads without a network, and its start page is runnable."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from explorer_browser import find_browser, launched

pytestmark = pytest.mark.slow_lane

CHECKOUT = Path(__file__).resolve().parents[2]
#: What the dependency group docs of pyproject.toml installs, by the names of imports.
NEEDED = ("sphinx", "pydata_sphinx_theme", "myst_nb", "numpydoc", "ziamath", "ipykernel", "distributed")
#: A page of which one cell prints what the other one would not reach.
RAISES = """---
file_format: mystnb
kernelspec:
  name: python3
---

# A page

```{code-cell} python
print("before")
assert 1 + 1 == 3
```
"""
#: How high the text of a how-to page may be in a window of 1440 x 900: a screen, and a tenth for other fonts.
SCREEN = {"width": 1440, "height": 900}
HIGHEST = 1000
#: A command that goes on while the next one begins.
BACKGROUND = re.compile(r"(?<!&)&\s*$")
TUTORIALS = sorted((CHECKOUT / "docs" / "tutorials").glob("*.md"))
#: Elements that load what their attribute names, as the browser comes to them. `a` only leads somewhere.
LOADING = {
    **dict.fromkeys(
        ["script", "img", "iframe", "source", "audio", "video", "embed", "track"], ("src", "srcset")
    ),
    "link": ("href",),
    "object": ("data",),
}
#: Links of a head that no browser loads.
NOT_LOADED = {"canonical", "index", "search", "next", "prev", "author", "license"}


class Page(HTMLParser):
    """The links, the loaded resources and the anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links, self.loaded, self.anchors = list[str](), list[str](), set[str]()
        self.formulas = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what an element names."""
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given["id"]} if "id" in given else set()
        self.formulas += tag == "math"
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag == "link" and set(given.get("rel", "").split()) & NOT_LOADED:
            return
        self.loaded += [given[name] for name in LOADING.get(tag, ()) if name in given]


@pytest.fixture(scope="module")
def site(made_once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the folder of the built site."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed: the dependency group docs of pyproject.toml")

    def build(out: Path) -> None:
        words = [sys.executable, CHECKOUT / "scripts" / "build_site.py", out]
        done = subprocess.run(words, cwd=out.parent, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stdout == f"{out / 'index.html'}\n"

    return made_once("site", build)


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    """Return every page of the site, by its path."""
    found = (
        path for path in site.rglob("*.html") if "_static" not in path.parts
    )  # there a template of the theme
    return {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in found}


def local(base: Path, link: str) -> tuple[Path, str]:
    """Return the file that a link of a page leads to, and the anchor in it."""
    parts = urlsplit(link)
    return ((base.parent / unquote(parts.path)).resolve() if parts.path else base), unquote(parts.fragment)


def test_every_page_is_built(pages: dict[Path, Page], site: Path) -> None:
    """Every page of docs/ is a page of the site, and so are the changelog and the page for contributors."""
    docs = CHECKOUT / "docs"
    sources = [
        *docs.glob("*.md"),
        *TUTORIALS,
        CHECKOUT / "CHANGELOG.md",
        CHECKOUT / "CONTRIBUTING.md",
    ]
    wanted = {(site / path.relative_to(CHECKOUT)).with_suffix(".html").resolve() for path in sources}
    assert len(wanted) > 20
    assert wanted <= pages.keys()


def test_nothing_is_loaded_from_a_network(pages: dict[Path, Page]) -> None:
    """Scripts, styles, fonts and pictures of every page are files of the site."""
    assert any(page.loaded for page in pages.values())
    for path, page in pages.items():
        for resource in page.loaded:
            parts = urlsplit(resource)
            assert not parts.netloc, (path.name, resource)
            assert parts.scheme in ("", "data"), (path.name, resource)
            assert parts.scheme or local(path, resource)[0].is_file(), (path.name, resource)


def test_styles_load_nothing_from_a_network(site: Path) -> None:
    """No style sheet, and no style in a page, names a server."""
    sheets = [*site.rglob("*.css"), *site.rglob("*.html")]
    for path in sheets:
        text = path.read_text(encoding="utf-8")
        styles = [text] if path.suffix == ".css" else re.findall(r"<style.*?</style>", text, re.S)
        for style in styles:
            assert re.findall(r"(?:url\(|@import)\s*['\"]?\s*(?:https?:)?//[^)]*", style) == [], path.name


def outside(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield the links of the pages that lead out of the site."""
    yield from (link for page in pages.values() for link in page.links if urlsplit(link).scheme)


def test_links_inside_lead_somewhere(pages: dict[Path, Page]) -> None:
    """Every link of a page to another one, or to a file, finds it, and the anchor in it."""
    followed = 0
    for path, page in pages.items():
        for link in page.links:
            if urlsplit(link).scheme:
                continue
            file, anchor = local(path, link)
            assert file.is_file(), (path.name, link)
            assert not anchor or file not in pages or anchor in pages[file].anchors, (path.name, link)
            followed += 1
    assert followed > 500


def test_links_outside_are_named_here(pages: dict[Path, Page]) -> None:
    """Links to servers, which no test follows, lead to these places alone."""
    places = {urlsplit(link).netloc for link in outside(pages)}
    assert places <= {"keepachangelog.com", "semver.org"}


def test_only_public_names_are_in_the_reference(pages: dict[Path, Page], site: Path) -> None:
    """The page of the interface has every public name, the accessor and the base class of models, and no other."""
    import sweep

    page = pages[(site / "docs" / "api.html").resolve()]
    described = {anchor for anchor in page.anchors if anchor.startswith(("sweep.", "kernels."))}
    classes = {"sweep.model.description.Model"}
    public = {f"sweep.{name}" for name in sweep.__all__ if name != "__version__"} | classes
    assert public <= described
    members = {name for name in described - public if name.rpartition(".")[0] not in public}
    assert members == set()


def test_it_is_searched_from_disk(site: Path) -> None:
    """In a browser, without a server: a word leads to pages that have it, and nothing is an error."""
    browser, asked = find_browser(), "separatrix"
    if browser is None:
        pytest.skip("no chromium and no Chrome on the path")
    words = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"]
    page = f"{(site / 'search.html').as_uri()}?q={asked}"
    done = subprocess.run(
        [browser, *words, "--virtual-time-budget=5000", page], capture_output=True, text=True, check=False
    )
    found = re.search(r'<ul[^>]*class="search"[^>]*>(.*?)</ul>', done.stdout, re.S)
    assert found, done.stderr
    results = re.findall(r'href="([^"?#]+)', found[1])
    assert len(results) >= 3
    assert all(asked in (site / result).read_text(encoding="utf-8").lower() for result in results)
    assert [line for line in done.stderr.splitlines() if "CONSOLE" in line and "[PST]" not in line] == []


def test_a_howto_page_is_one_screen(site: Path) -> None:
    """Each page of the list is about as high as a window, and every page of its table is in it; a reference is not."""
    pytest.importorskip("playwright")
    browser = find_browser()
    if browser is None:
        pytest.skip("no chromium and no Chrome on the path")
    text = (CHECKOUT / "docs" / "howto.md").read_text(encoding="utf-8")
    names = re.findall(r"\]\((\S+)\.md\) \|$", text, re.M)
    assert names == text.partition(":hidden:")[2].replace("```", "").split()
    heights = {}
    with launched(browser) as running:
        page = running.new_page(viewport=SCREEN)
        for name in [*names, "atlas"]:
            page.goto((site / "docs" / f"{name}.html").as_uri())
            heights[name] = page.locator("article.bd-article").bounding_box()["height"]
    assert heights.pop("atlas") > 3 * HIGHEST
    assert {name: height for name, height in heights.items() if height > HIGHEST} == {}


def notebooks(site: Path) -> dict[str, dict[str, Any]]:
    """Return the executed notebooks that the pages of tutorials offer, by their names."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in site.rglob("*.ipynb")}


@pytest.mark.compiled
def test_tutorials_are_executed(site: Path) -> None:
    """Each is offered as a notebook, all cells of which were run, and what they print is in one piece."""
    found = notebooks(site)
    assert found.keys() == {path.stem for path in TUTORIALS}
    for name, book in found.items():
        for cell in (each for each in book["cells"] if each["cell_type"] == "code"):
            assert cell["execution_count"], (name, cell["source"])
            streams = [each["name"] for each in cell["outputs"] if each["output_type"] == "stream"]
            assert streams in ([], ["stdout"]), (name, cell["source"])


@pytest.mark.compiled
def test_a_tutorial_shows_nothing_of_this_machine(site: Path) -> None:
    """No bar says how fast it is, and no path where the checkout lies."""
    for name, book in notebooks(site).items():
        text = json.dumps(book)
        assert "finished after" not in text, name
        assert str(CHECKOUT) not in text, name


def bash_cells(text: str) -> list[list[str]]:
    """Return the commands of each cell of bash, a command that is continued on the next line in one piece."""
    cells = re.findall(r"^%%bash[^\n]*\n(.*?)^```$", text, re.M | re.S)
    return [cell.replace("\\\n", " ").splitlines() for cell in cells]


def speaks_apart(line: str) -> bool:
    """Return whether a command of the program keeps its standard error apart, where it fails the build."""
    parts = re.split(r"\||;|&&", line)
    return any(re.search(r"\beulerdisk ", part) and "2>&1" not in part for part in parts)


def waits(cell: list[str]) -> bool:
    """Return whether a cell waits for what it has begun."""
    return any(re.search(r"\bwait\b", line) for line in cell)


def test_a_failing_command_ends_a_tutorial() -> None:
    """Bash stops at the first command that fails, also in a pipe; every page holds its numbers, or its bits."""
    assert speaks_apart("ls; eulerdisk verify a.nc | tail -n 1 2>&1")
    assert not speaks_apart("eulerdisk verify a.nc 2>&1 | tail -n 1")
    for path in TUTORIALS:
        text = path.read_text(encoding="utf-8")
        called = re.findall(r"^%%bash(.*)$", text, re.M)
        assert all(words.startswith(" -eo pipefail") for words in called), path.stem
        for cell in bash_cells(text):
            assert not [line for line in cell if speaks_apart(line)], path.stem
            assert waits(cell) or not any(BACKGROUND.search(line) for line in cell), path.stem
        assert not re.search(r"^!(?!\[)", text, re.M), path.stem
        assert "\nassert " in text or "\n    assert " in text or path.stem == "regression", path.stem


def test_a_cell_that_raises_ends_the_build(tmp_path: Path) -> None:
    """A site of one page with a false assertion is not built; the message has the assertion."""
    pytest.importorskip("myst_nb")
    (tmp_path / "docs" / "tutorials").mkdir(parents=True)
    (tmp_path / "docs" / "index.md").write_text("# Site\n\n```{toctree}\ntutorials/page\n```\n")
    (tmp_path / "docs" / "tutorials" / "page.md").write_text(RAISES)
    words = [
        "-b",
        "dummy",
        "-W",
        "-q",
        "-c",
        CHECKOUT / "docs",
        "-d",
        tmp_path / "kept",
        tmp_path,
        tmp_path / "out",
    ]
    where = os.pathsep.join([str(CHECKOUT), str(CHECKOUT / "docs" / "_site")])
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": where},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode != 0
    assert "assert 1 + 1 == 3" in done.stderr
