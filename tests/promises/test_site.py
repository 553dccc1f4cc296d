"""The documentation builds without warnings, works without a network, and its start page runs."""

import html
import json
import os
import re
import subprocess
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from explorer_browser import find_browser, launched
from processes import CHECKOUT, python

pytestmark = pytest.mark.release

#: Import names of what the dependency group docs of pyproject.toml installs.
NEEDED = (
    "sphinx",
    "pydata_sphinx_theme",
    "myst_nb",
    "numpydoc",
    "ziamath",
    "fontTools",
    "ipykernel",
    "distributed",
)
#: A page with a cell that raises before the next one prints.
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
#: Maximum height of a how-to section in a window of 1440 x 900: one screen plus a tenth for other fonts.
SCREEN = {"width": 1440, "height": 900}
HIGHEST = 1000
#: How-to pages, and their sections that may be higher because they are reference tables.
HOWTO, TABLES = ("explorer", "starts", "figures", "motions", "runs"), {("figures", "options")}
#: JavaScript that returns the heights of a page's sections by name.
HEIGHTS = """() => Object.fromEntries(
    [...document.querySelectorAll("article.bd-article > section > section")].map(
        (section) => [section.id, section.getBoundingClientRect().height]))"""
#: A command that continues while the next one starts.
BACKGROUND = re.compile(r"(?<!&)&\s*$")
TUTORIALS = sorted((CHECKOUT / "docs" / "tutorials").glob("*.md"))
#: What a browser loads from a server: loading elements (`a` is only a link) and styles.
FROM_A_SERVER = re.compile(
    r"<(?:script|img|iframe|source|audio|video|embed|track|object)\b[^>]*\b(?:src|srcset|data)=[\"']?(?:https?:)?//"
    r"|<link\b(?![^>]*rel=[\"'](?:canonical|index|search|next|prev|author|license))[^>]*href=[\"'](?:https?:)?//"
    r"|(?:url\(|@import)\s*[\"']?\s*(?:https?:)?//"
)


@pytest.fixture(scope="module")
def site(made_once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the folder of the built site."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed: the dependency group docs of pyproject.toml")

    def build(out: Path) -> None:
        done = python(CHECKOUT / "scripts" / "build_site.py", out, folder=out.parent)
        assert done.returncode == 0, done.stderr
        assert done.stdout == f"{out / 'index.html'}\n"

    return made_once("site", build)


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, str]:
    """Return the text of every page of the site by path."""
    # _static contains a template of the theme.
    found = (path for path in site.rglob("*.html") if "_static" not in path.parts)
    return {path.resolve(): path.read_text(encoding="utf-8") for path in found}


def test_every_page_is_built(pages: dict[Path, str], site: Path) -> None:
    """Every page of docs/ is on the site, and so are the changelog and the page for contributors."""
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


def test_nothing_is_loaded_from_a_network(site: Path) -> None:
    """Scripts, styles, fonts and pictures of all pages and style sheets are files of the site."""
    assert FROM_A_SERVER.search('<script async src="https://a.b/c.js">')
    for path in [*site.rglob("*.css"), *site.rglob("*.html")]:
        assert FROM_A_SERVER.search(path.read_text(encoding="utf-8")) is None, path


def test_links_lead_somewhere(pages: dict[Path, str]) -> None:
    """Links reach their page and anchor, or their file; only a few outside hosts appear."""
    anchors = {path: set(re.findall(r'\bid="([^"]+)"', text)) for path, text in pages.items()}
    followed, outside = 0, set()
    for path, text in pages.items():
        for link in re.findall(r'<a\b[^>]*\bhref="([^"]+)"', text):
            parts = urlsplit(html.unescape(link))
            if parts.scheme:
                outside.add(parts.netloc)
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert file.is_file(), (path.name, link)
            anchor = unquote(parts.fragment)
            assert not anchor or file not in pages or anchor in anchors[file], (path.name, link)
            followed += 1
    assert followed > 500
    assert outside <= {"keepachangelog.com", "scientific-python.org", "semver.org"}


def test_only_public_names_are_in_the_reference(pages: dict[Path, str], site: Path) -> None:
    """The reference lists every public name, the accessor and the base class of models, and nothing else."""
    import sweep

    page = pages[(site / "docs" / "api.html").resolve()]
    described = set(re.findall(r'\bid="((?:sweep|kernels)\.[^"]+)"', page))
    classes = {"sweep.model.description.Model"}
    public = {f"sweep.{name}" for name in sweep.__all__ if name != "__version__"} | classes
    assert public <= described
    members = {name for name in described - public if name.rpartition(".")[0] not in public}
    assert members == set()


def test_it_is_searched_from_disk(site: Path) -> None:
    """Search works in a browser without a server: a word finds its pages, without errors."""
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


def test_a_section_of_a_howto_page_is_one_screen(site: Path) -> None:
    """Each is about one window high at most, except references; the list has every page of the tables."""
    pytest.importorskip("playwright")
    browser = find_browser()
    if browser is None:
        pytest.skip("no chromium and no Chrome on the path")
    text = (CHECKOUT / "docs" / "howto.md").read_text(encoding="utf-8")
    names = re.findall(r"\]\((\S+)\.md\) \|$", text, re.M)
    assert names == text.partition(":hidden:")[2].replace("```", "").split()
    assert set(names) >= {*HOWTO}
    heights = {}
    with launched(browser) as running:
        page = running.new_page(viewport=SCREEN)
        for name in (*HOWTO, "atlas"):
            page.goto((site / "docs" / f"{name}.html").as_uri())
            heights |= {(name, section): height for section, height in page.evaluate(HEIGHTS).items()}
    high = {place for place, height in heights.items() if height > HIGHEST}
    assert {name for name, _ in high - TABLES} == {"atlas"}


def notebooks(site: Path) -> dict[str, dict[str, Any]]:
    """Return the executed notebooks that the tutorial pages offer, by name."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in site.rglob("*.ipynb")}


@pytest.mark.compiled
def test_tutorials_are_executed(site: Path) -> None:
    """Each is offered as a notebook with all cells run, and each cell's output is in one piece."""
    found = notebooks(site)
    assert found.keys() == {path.stem for path in TUTORIALS}
    for name, book in found.items():
        for cell in (each for each in book["cells"] if each["cell_type"] == "code"):
            assert cell["execution_count"], (name, cell["source"])
            streams = [each["name"] for each in cell["outputs"] if each["output_type"] == "stream"]
            assert streams in ([], ["stdout"]), (name, cell["source"])


@pytest.mark.compiled
def test_a_tutorial_shows_nothing_of_this_machine(site: Path) -> None:
    """No progress bar shows a speed, and no path shows the location of the checkout."""
    for name, book in notebooks(site).items():
        text = json.dumps(book)
        assert "finished after" not in text, name
        assert str(CHECKOUT) not in text, name


def bash_cells(text: str) -> list[list[str]]:
    """Return the commands of each bash cell, with continued lines joined."""
    cells = re.findall(r"^%%bash[^\n]*\n(.*?)^```$", text, re.M | re.S)
    return [cell.replace("\\\n", " ").splitlines() for cell in cells]


def speaks_apart(line: str) -> bool:
    """Return whether a command of the program does not redirect standard error, whose messages fail the build."""
    parts = re.split(r"\||;|&&", line)
    return any(re.search(r"\beulerdisk ", part) and "2>&1" not in part for part in parts)


def waits(cell: list[str]) -> bool:
    """Return whether a cell waits for its background commands."""
    return any(re.search(r"\bwait\b", line) for line in cell)


def test_a_failing_command_ends_a_tutorial() -> None:
    """Bash stops at the first failing command, also in a pipe; every page asserts its results."""
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
    """A site with a false assertion is not built, and the message quotes the assertion."""
    pytest.importorskip("myst_nb")
    (tmp_path / "docs" / "tutorials").mkdir(parents=True)
    (tmp_path / "docs" / "index.md").write_text("# Site\n\n```{toctree}\ntutorials/page\n```\n")
    (tmp_path / "docs" / "tutorials" / "page.md").write_text(RAISES)
    words = ["-b", "dummy", "-W", "-q", "-c", CHECKOUT / "docs", "-d", tmp_path / "kept"]
    where = os.pathsep.join([str(CHECKOUT), str(CHECKOUT / "docs" / "_site")])
    done = python("-m", "sphinx", *words, tmp_path, tmp_path / "out", folder=tmp_path, packages=where)
    assert done.returncode != 0
    assert "assert 1 + 1 == 3" in done.stderr
