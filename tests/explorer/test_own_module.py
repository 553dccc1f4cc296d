"""The WebAssembly module of a body's or system's page: compiled once on this machine and cached."""

import json
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from messages import refused

from kernels.bodies.shapes import NAMES
from kernels.page.bodies import entries_and_sizes
from sweep.explorer.own_module import kernels_of
from sweep.model.bodies.tables import LENGTHS
from sweep.request.spec import SweepSpec


def test_the_module_of_a_page_is_kept(tmp_path, monkeypatch):
    """It is compiled once for all processes; an incomplete file is replaced."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    made = []
    monkeypatch.setattr(
        "sweep.explorer.own_module._make_module", lambda *given: made.append(given) or b"a module"
    )
    torus, ball = SweepSpec.preset("torus"), SweepSpec.preset("egg")
    assert kernels_of(torus) == kernels_of(torus.replace(tube=0.3)) == b"a module"
    assert (kernels_of(ball), len(made)) == (b"a module", 2)
    for path in tmp_path.glob("*/page_bodies*"):
        path.write_bytes(path.read_bytes()[:-1] + b"!")
    assert (kernels_of(torus), len(made)) == (b"a module", 3)


def test_a_module_that_is_asked_for_twice_at_once_is_made_once(tmp_path, monkeypatch):
    """If several threads request a page's module, the others wait for the first."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    made = []

    def make(*given):
        made.append(given)
        time.sleep(0.2)
        return b"a module"

    monkeypatch.setattr("sweep.explorer.own_module._make_module", make)
    with ThreadPoolExecutor(3) as pool:
        assert set(pool.map(kernels_of, 3 * [SweepSpec.preset("torus")])) == {b"a module"}
    assert len(made) == 1


@pytest.mark.parametrize("records", ["no", "yes"])
def test_bodies_of_the_same_kernels_have_the_same_module(tmp_path, monkeypatch, records):
    """A page has its body's entry points, whichever body the module was compiled for."""
    made = []
    monkeypatch.setattr(
        "sweep.explorer.own_module._make_module", lambda *given: made.append(given[-1]) or b"a module"
    )
    moments = {"axial_moment": 0.5, "transverse_moment": 0.4, "contact": records, "path": records}
    for body in NAMES:
        monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / body))
        lengths = zip(LENGTHS[body], (0.4, 0.1), strict=False)
        kernels_of(SweepSpec(body=body, **dict(lengths), **moments))
        assert entries_and_sizes(*json.loads(made[-1])) == entries_and_sizes(body, *[records == "yes"] * 2)
    assert len(made) == 6
    assert len(set(made)) == 3


@pytest.mark.parametrize("asked", ["contact", "path"])
def test_a_module_records_what_its_spec_asks_for(tmp_path, monkeypatch, asked):
    """Contact forces and paths are recorded separately."""
    made = []
    monkeypatch.setattr(
        "sweep.explorer.own_module._make_module", lambda *given: made.append(given[-1]) or b"a module"
    )
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    kernels_of(SweepSpec(body="torus", tube=0.4, **{asked: "yes"}))
    found = entries_and_sizes(*json.loads(made[-1]))
    expected, other = (entries_and_sizes("torus", *flags) for flags in ((True, False), (False, True)))
    assert found == (expected if asked == "contact" else other)
    assert expected != other


def test_a_system_that_cannot_be_compiled_for_a_page_is_refused(tmp_path, monkeypatch):
    """The refusal explains the error in one sentence."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("sweep.explorer.own_module._BUILD", "raise ValueError('no such target')")
    with refused("ValueError: no such target"):
        kernels_of(SweepSpec.preset("thomas"))
