"""The models that a request may name: registered ones, and never anything else."""

import os
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from sweep.errors import RequestError
from sweep.model import registry
from sweep.model.disk.model import DISK, Disk
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec


class Coin(Disk):
    """A second model: the disk under another name."""

    name = "coin"


COIN = Coin()


class Presets(Disk):
    """A model with a preset of its own."""

    name = "preset"


WITH_PRESET = Presets()
NO_MODEL = {"name": "no_model"}


@pytest.fixture
def installed(monkeypatch):
    """Return a function that registers models: name -> value of the entry point."""

    def forget():
        registry.named.cache_clear()
        registry._registered.cache_clear()

    def register(**values):
        points = [EntryPoint(name, value, registry.GROUP) for name, value in values.items()]
        monkeypatch.setattr(registry, "entry_points", lambda group: points if group == registry.GROUP else [])
        forget()

    forget()
    monkeypatch.setitem(sys.modules, "installed_models", sys.modules[__name__])
    yield register
    forget()


def test_the_disk_needs_no_registration(installed):
    """It is the model of a request that names none, and no other distribution can take its name."""
    installed(disk="installed_models:COIN", lossy_disk="installed_models:COIN")
    assert registry.named("disk") is DISK
    assert SweepSpec().model is DISK
    assert registry.names() == ("disk", "lossy_disk")
    assert list(registry.every()) == [DISK, LOSSY_DISK]


def test_a_registered_model_is_named_in_a_request(installed):
    """A spec, its text and its TOML file name the model, and it is loaded once."""
    installed(zebra="installed_models:WITH_PRESET", coin="installed_models:COIN")
    assert registry.names() == ("disk", "lossy_disk", "coin", "zebra")
    assert registry.named("coin") is registry.named("coin") is COIN
    spec = SweepSpec(model="coin", tilt="0.1,0.2")
    assert spec.model is COIN
    assert spec.replace(alpha=1.0).model is COIN
    assert SweepSpec.from_canonical(spec.canonical()) == spec == eval(repr(spec))
    assert 'model = "coin"' in spec.to_toml().splitlines()
    assert '"model":"coin"' in spec.canonical()
    assert spec != SweepSpec(tilt="0.1,0.2")
    assert spec.fingerprint() != SweepSpec(tilt="0.1,0.2").fingerprint()


class Braked(Disk):
    """A model that some of its words choose."""

    name, chosen_by = "braked", ("brake", "drum")


BRAKED = Braked()


def test_a_word_chooses_a_registered_model(installed):
    """One of its words is enough; a request without any has the default, and what no model knows chooses none."""
    installed(braked="installed_models:BRAKED", coin="installed_models:COIN")
    assert registry.chosen(["drum", "spin"]) is BRAKED
    assert registry.chosen(["spin"]) is None
    assert registry.chosen([]) is None


def test_a_preset_of_a_registered_model_is_found(installed, tmp_path, monkeypatch):
    """A preset is named without its model, which its file names; presets of the disk come first."""
    (tmp_path / "wobbling.toml").write_text('model = "preset"\ntilt = 0.25\n')
    (tmp_path / "rolling.toml").write_text('model = "preset"\ntilt = 0.25\n')
    monkeypatch.setattr(Presets, "presets", tmp_path)
    installed(preset="installed_models:WITH_PRESET")
    found = SweepSpec.preset("wobbling")
    assert (found.model, found.tilt) == (WITH_PRESET, 0.25)
    assert SweepSpec.preset("rolling").model is DISK
    with pytest.raises(RequestError, match="circling, rolling, spinning, coin, toy, rolling, wobbling"):
        SweepSpec.preset("waddling")


def test_an_unknown_model_is_refused(installed):
    """The message has the models that there are; what is named is not looked for anywhere else."""
    installed(coin="installed_models:COIN")
    for name in ("sphere", "installed_models:COIN", "os", ""):
        with pytest.raises(RequestError, match="disk, lossy_disk, coin") as caught:
            registry.named(name)
        assert caught.value.where == "model"
        assert caught.value.hint


def test_an_entry_point_that_is_no_model_is_refused(installed):
    """Another thing, a class, a model of another name, and what cannot be loaded are refused under their names."""
    for name, value in [
        ("no_model", "installed_models:NO_MODEL"),
        ("coin", "installed_models:Coin"),
        ("sphere", "installed_models:COIN"),
        ("gone", "installed_models:GONE"),
        ("gone", "no_such_distribution.model:MODEL"),
    ]:
        installed(**{name: value})
        with pytest.raises(RequestError) as caught:
            SweepSpec(model=name)
        assert caught.value.where == f"model={name}", (name, value)
        assert value in caught.value.message, (name, value)
        assert caught.value.hint, (name, value)


@pytest.fixture(params=["raise TypeError('cannot add\\n1')", "import no_such_distribution", "1 / 0"])
def broken(request, installed, tmp_path, monkeypatch):
    """Register a sound model between two whose module fails in one way when it is imported."""
    (tmp_path / "broken_model.py").write_text(request.param)
    monkeypatch.syspath_prepend(str(tmp_path))
    installed(broken="broken_model:A", coin="installed_models:COIN", wrecked="broken_model:B")


@pytest.mark.usefixtures("broken")
def test_a_model_that_fails_when_it_is_imported_is_refused_by_name():
    """A request for a module that raises ends with one line that names it; the models beside it are there."""
    with pytest.raises(RequestError, match=r"broken_model:B.*cannot be imported") as caught:
        registry.named("wrecked")
    assert caught.value.where == "model=wrecked"
    assert "\n" not in str(caught.value)
    assert list(registry.every()) == [DISK, LOSSY_DISK, COIN]


@pytest.mark.usefixtures("broken")
def test_a_broken_model_spoils_no_other_request():
    """The presets and the suggestions are those of the models that can be loaded."""
    with pytest.raises(RequestError, match="Did you mean rolling") as caught:
        SweepSpec.preset("rollin")
    assert caught.value.where == "rollin"
    assert SweepSpec(model="coin").model is COIN


def test_the_models_are_those_of_the_entry_points(tmp_path):
    """A distribution that states an entry point of the group is found by its metadata, and loaded only when named."""
    (tmp_path / "wheels.py").write_text(
        "print('loaded')\nfrom sweep.model.disk.model import Disk\n\n"
        "class Wheel(Disk):\n    name = 'wheel'\n\nWHEEL = Wheel()\n"
    )
    metadata = tmp_path / "wheels-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: wheels\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[eulerdisk.models]\nwheel = wheels:WHEEL\n")
    code = (
        f"import sys; sys.path.append({str(tmp_path)!r}); from sweep.model import registry; print(registry.names()); "
        "registry.named('disk'); print(registry.named('wheel').name)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(registry.__file__).parents[2],
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split("\n")[:3] == ["('disk', 'lossy_disk', 'wheel')", "loaded", "wheel"]
