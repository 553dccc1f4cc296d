"""The gallery shows every figure with the command that makes it."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def gallery():
    """Return scripts/make_gallery.py as a module."""
    spec = importlib.util.spec_from_file_location("make_gallery", CHECKOUT / "scripts" / "make_gallery.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_gallery"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["make_gallery"]


def test_the_page_is_what_the_script_writes(gallery):
    """docs/gallery.md is the page of the script, to the letter."""
    assert (CHECKOUT / "docs" / "gallery.md").read_text(encoding="utf-8") == gallery.page()


def test_every_figure_is_there_and_small(gallery):
    """Every figure of the page lies beside it, and none is larger than 400 kB."""
    shown = re.findall(r"!\[[^]]*\]\(([^)]+)\)", gallery.page())
    assert len(shown) == len(gallery.ENTRIES) >= 5
    assert all((CHECKOUT / "docs" / name).stat().st_size < 400_000 for name in shown)


def test_every_command_names_a_script(gallery):
    """The commands of the page run scripts that exist, and the last one writes the figure."""
    for entry in gallery.ENTRIES:
        for command in entry.commands:
            assert (CHECKOUT / command.split()[1]).is_file()
        assert entry.commands[-1].endswith(f"-o {{folder}}/{entry.file}")
