"""A request may name only the models of the registry."""

import pytest
from messages import refused

from sweep.errors import RequestError
from sweep.model import registry
from sweep.model.bodies.model import BODIES
from sweep.model.disk.model import DISK
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec


def test_the_disk_is_the_default():
    """A request that names no model gets the disk; the lossy disk is also registered."""
    assert registry.named("disk") is DISK
    assert SweepSpec().model is DISK
    assert registry.names() == ("disk", "lossy_disk", "bodies", "lossy_bodies")
    assert list(registry.every()) == [DISK, LOSSY_DISK, BODIES, LOSSY_BODIES]


def test_a_word_chooses_a_model():
    """One input of a model chooses it. No input means the default; an unknown input chooses no model."""
    assert registry.chosen(["rolling_friction", "spin"]) is LOSSY_DISK
    assert registry.chosen(["tube"]) is BODIES
    assert registry.chosen(["tube", "rolling_friction"]) is LOSSY_BODIES
    assert registry.chosen(["rolling_friction"], "bodies") is LOSSY_BODIES
    assert registry.chosen(["tube"], "lossy_disk") is LOSSY_BODIES
    assert registry.chosen(["spin"]) is None
    assert registry.chosen([]) is None


@pytest.mark.parametrize("name", ["sphere", "sweep.model.disk.model:DISK", "os", ""])
def test_an_unknown_model_is_refused(name, tmp_path, monkeypatch):
    """The message lists the models; no module of that name is imported."""
    (tmp_path / "sphere.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    with refused("disk, lossy_disk, bodies, lossy_bodies") as caught:
        SweepSpec(model=name)
    assert caught.value.where == "model"
    assert "mine.py" in caught.value.hint


def test_a_misspelt_preset_is_told_the_right_one():
    """The message lists all presets, those of systems last, and suggests the nearest name."""
    known = "circling, rolling, spinning, coin, toy, egg, thick_coin, torus, true_edge, driven_pendulum"
    with refused(known, "rolling?"):
        SweepSpec.preset("rollin")
    with refused("kapitza?"):
        SweepSpec.preset("kapiza")


def test_an_atlas_names_a_model_and_imports_nothing(tmp_path, monkeypatch):
    """A canonical text with an unknown model is refused, even if a module of that name exists."""
    (tmp_path / "antigravity_model.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    text = SweepSpec.preset("toy").canonical()
    assert '"lossy_disk"' in text
    with pytest.raises(RequestError, match="antigravity_model"):
        SweepSpec.from_canonical(text.replace('"lossy_disk"', '"antigravity_model"'))
