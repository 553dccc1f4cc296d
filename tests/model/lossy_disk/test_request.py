"""The inputs of the lossy disk: which ones choose it, what its laws need, and what is refused."""

import itertools
import math

import numpy as np
import pytest
from messages import assert_facts, missing, refused

from kernels.lossy_disk import arrays, integrate
from sweep.engine.grid import whole
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk import model as variants
from sweep.model.lossy_disk import tables
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec

#: Inputs that satisfy the needs of every law.
FULL = {"mass": 0.4, "air_law": "bildsten", "air_viscosity": 1.8e-5, "air_density": 1.2}


def test_the_tables_are_the_rows_of_the_kernels():
    """Tables and kernel arrays have the same names in the same order, and the same ending codes."""
    assert tuple(LOSSY_DISK.parameters) == arrays.PARAMETERS
    assert arrays.SETTINGS[: len(LOSSY_DISK.settings)] == tuple(LOSSY_DISK.settings)
    assert {*arrays.MEASURES, *arrays.COUNTS} <= set(LOSSY_DISK.variables)
    assert tuple(measure for _, measure in tables.LOSSES.values()) == arrays.LOSSES
    assert [getattr(arrays, law) for law in ("NONE", "MOFFATT", "BILDSTEN")] == [
        tables.AIR_LAWS.index(law) for law in (tables.NO_AIR, tables.MOFFATT, tables.BILDSTEN)
    ]


def test_a_word_of_a_loss_chooses_the_model():
    """Any loss input chooses it, even zero or a column of a table; the canonical text restores the spec."""
    for words in [
        {"rolling_friction": "1mm"},
        {"pivoting_friction": 0},
        {"contour_friction": "0,1um"},
        {"contour_damping": 1e-6, "mass": 0.4},
        {"air_law": "none"},
        {"air_density": "0 kg/m3"},
        {"starts": {"tilt": [0.1, 0.2], "rolling_friction [mm]": [0.0, 0.1]}},
    ]:
        spec = SweepSpec(tilt="1deg", **words) if "starts" not in words else SweepSpec(**words)
        assert spec.model is LOSSY_DISK, words
        assert '"model":"lossy_disk"' in spec.canonical(), words
        assert SweepSpec.from_canonical(spec.canonical()) == spec, words
        if "starts" not in words:
            assert eval(repr(spec)) == spec, words


def test_without_one_it_is_the_disk():
    """The text and the fingerprint of its spec do not mention losses."""
    for words in [{}, {"tilt": "1deg,2deg", "fall_tilt": "80deg", "contact": "yes"}]:
        spec = SweepSpec(**words)
        assert spec.model is DISK, words
        assert not {"model", *LOSSY_DISK.chosen_by} & set(eval(spec.canonical())), words


def test_words_of_a_motion_choose_no_losses():
    """`mass` and `friction` belong to single motions of any disk; `flat_tilt` replaces another input."""
    for name in ("mass", "friction", "flat_tilt"):
        assert name not in LOSSY_DISK.chosen_by
        with refused(name):
            SweepSpec(**{name: 0.5})


def test_files_presets_and_changes_choose_it_too(spec_file, tmp_path):
    """The input may come with a preset, on the command line, in a file, or in a table next to the file."""
    made = SweepSpec.from_words("rolling", ["rolling_friction=10um"])
    assert (made.model, made.axes) == (LOSSY_DISK, ("roll_rate", "tilt"))
    assert SweepSpec.preset("rolling", rolling_friction="10um") == made
    assert SweepSpec.read("rolling", rolling_friction="10um") == made
    assert SweepSpec.preset("rolling").replace(rolling_friction="10um") == made
    assert SweepSpec.from_toml(spec_file('rolling_friction = "10um"\n')).model is LOSSY_DISK
    assert SweepSpec.from_toml(spec_file(made.to_toml())) == made
    (tmp_path / "pushes.csv").write_text("# pushes\ntilt [deg];contour_friction [mm]\n1;0.1\n2;0\n")
    table = SweepSpec.from_toml(spec_file('starts = "pushes.csv"\n'))
    assert (table.model, table.listed) == (LOSSY_DISK, ("tilt", "contour_friction"))


def test_a_spec_that_is_changed_keeps_its_words():
    """Axes keep their places. A changed setting that losses do not have is refused, not dropped."""
    spec = SweepSpec(alpha="0.5,1", tilt="1deg:5deg:3", duration="20s", title="Mine")
    changed = spec.replace(contour_friction="1um,2um")
    assert changed.axes == ("alpha", "tilt", "contour_friction")
    assert (changed.duration, changed.title) == (20.0, "Mine")
    assert changed.replace(tilt="3deg").model is LOSSY_DISK
    with refused("flat_tilt"):
        spec.replace(fall_tilt="80deg").replace(contour_friction="1um")


def test_what_is_refused():
    """The message names the input, what is wrong and what to do."""
    for words, where, facts in [
        ({"rolling_friction": -1e-6}, "rolling_friction=-1e-06", ["rolling_friction >= 0"]),
        ({"contour_friction": "-1um:1um:5"}, "contour_friction=-1um:1um:5", ["contour_friction >= 0"]),
        (
            {"pivoting_friction": 0.5},
            "pivoting_friction",
            ["pivoting_friction=0.5", "shorter than the radius"],
        ),
        (
            {"rolling_friction": "1mm:2cm:5", "radius": "12mm,1m"},
            "rolling_friction=1mm:2cm:5",
            ["1mm:2cm:5", "12mm"],
        ),
        ({"contour_damping": 1e-6}, "mass", ["contour_damping needs the mass", "mass=0.4kg"]),
        (FULL | {"mass": "unknown"}, "mass", ["air_law=bildsten needs the mass"]),
        (
            FULL | {"air_law": "none"},
            "air_viscosity",
            ["no law uses it", "air_law=moffatt", "air_viscosity=0"],
        ),
        (
            {"air_density": 1.2, "rolling_friction": 1e-5},
            "air_density",
            ["no law uses it", "air_law=bildsten"],
        ),
        ({"air_law": "moffatt", "mass": 1}, "air_law", ["viscosity", "Pa s"]),
        (FULL | {"air_density": 0}, "air_law", ["needs the density", "kg m-3"]),
        (FULL | {"air_law": "stokes"}, "air_law", ["none or moffatt or bildsten", "stokes"]),
        ({"rolling_friction": 0, "method": "exact"}, "method", ["rk4", "has no exact reduction"]),
        ({"rolling_friction": 0, "device": "cuda"}, "device", ["device is cpu"]),
        ({"rolling_friction": 0, "fall_tilt": "80deg"}, "fall_tilt", ["flat_tilt"]),
        ({"rolling_friction": 0, "contact": "yes"}, "contact", ["not a word"]),
        ({"flat_tilt": "89deg"}, "flat_tilt", ["fall_tilt"]),
        ({"rolling_friction": 0, "flat_tilt": "90deg"}, "flat_tilt=90deg", ["flat_tilt < 90 deg"]),
        ({"rolling_friction": 0, "friction": 0}, "friction=0", ["friction > 0"]),
        ({"rolling_friction": 0, "mass": "heavy"}, "mass=heavy", ["unknown"]),
        ({"model": "disk", "rolling_friction": 0}, "rolling_friction", ["a word of the model lossy_disk"]),
        ({"rolling_friction": "1kg"}, "rolling_friction=1kg", ["takes m, cm, inch"]),
        (FULL | {"air_viscosity": "1 kg"}, "air_viscosity=1 kg", ["Pa s"]),
    ]:
        with pytest.raises(RequestError) as caught:
            SweepSpec(**words)
        assert caught.value.where == where, (words, where, facts)
        assert all(fact in str(caught.value) for fact in facts), caught.value
        assert caught.value.hint, (words, where, facts)


def test_an_arm_of_a_table_is_held_against_the_radius_of_its_own_start(tmp_path):
    """The longest arm may exceed the smallest radius, but no arm may be as long as its own row's radius."""
    table = tmp_path / "coins.csv"
    table.write_text("tilt [deg],roll_rate,radius,contour_friction\n1,2,1,0.02\n1,20,0.01,0.001\n")
    assert SweepSpec.read("rolling", starts=table).model is LOSSY_DISK
    table.write_text("tilt [deg],roll_rate,radius,contour_friction\n1,2,1,0.02\n1,20,0.01,0.01\n")
    with refused("contour_friction=0.01 m", "radius=0.01 m", "row 2"):
        SweepSpec.read("rolling", starts=table)


def test_laws_with_what_they_need_are_taken():
    """Moffatt's law needs no density but accepts one; zero coefficients need nothing."""
    assert SweepSpec(**FULL).air_law == "bildsten"
    assert SweepSpec(air_law="moffatt", mass="400g", air_viscosity="18 uPa*s").air_viscosity == pytest.approx(
        1.8e-5
    )
    assert SweepSpec(**FULL | {"air_law": "moffatt"}).air_law == "moffatt"
    assert SweepSpec(contour_damping=0.0, air_viscosity=0.0).mass == "unknown"
    assert SweepSpec(**FULL | {"air_density": "1.2e-3 g/cm3"}).air_density == pytest.approx(1.2)


def test_starts_have_numbers_in_every_row():
    """An unneeded mass and unlimited friction get placeholder numbers, which are not computed or stored."""
    spec = SweepSpec(tilt="80deg", precession_rate="wobble", roll_rate="wobble", contour_friction="1um,2um")
    starts = whole(spec)
    assert list(starts) == list(arrays.PARAMETERS)
    assert starts["mass"].tolist() == [1.0, 1.0]
    assert starts["friction"].tolist() == [math.inf, math.inf]
    assert spec.computed == ("precession_rate", "roll_rate")
    assert not {"mass", "friction"} & {*spec.fixed, *spec.listed}
    given = SweepSpec(contour_friction=0.0, mass="7.5g", friction="0.1,0.2")
    assert whole(given)["friction"].tolist() == [0.1, 0.2]
    assert given.constants == {}
    assert "mass" in given.fixed


def test_the_settings_of_the_kernels():
    """They follow the inputs and encode the criterion's limit and reference, and the air law."""
    spec = SweepSpec(**FULL, duration="20s", step="1ms", criterion="amplification:7", roll_rate="steady",
                     precession_rate=1.0, flat_tilt="89deg", tolerance=1e-9)  # fmt: skip
    expected = [20.0, 1e-3, math.radians(89.0), 1e-9, 2.0, 7.0, 1.0, 2.0]
    np.testing.assert_allclose(LOSSY_DISK.kernel_settings(spec), expected, rtol=1e-15)
    plain = SweepSpec(rolling_friction=0.0, criterion="end_time < 3s")
    assert LOSSY_DISK.kernel_settings(plain).tolist() == [300.0, 0.0, math.radians(89.9), 1e-8, 0, 0, 0, 0]
    assert LOSSY_DISK.kernel_settings(plain.replace(criterion="departure:0.5")).tolist()[4:] == [
        1.0,
        0.5,
        0.0,
        0.0,
    ]
    assert LOSSY_DISK.kernel_settings(plain).size == len(arrays.SETTINGS)


def test_only_the_laws_of_a_request_are_compiled():
    """The kernel is the variant whose name encodes the laws."""
    for words, laws in [
        ({"contour_friction": 1e-6}, (True, False, False, False, "none", False)),
        ({"rolling_friction": "0,1um"}, (False, False, True, False, "none", False)),
        ({"pivoting_friction": 1e-6, "friction": 0.3}, (False, False, False, True, "none", True)),
        (
            FULL | {"rolling_friction": 1e-6, "contour_damping": 1e-9},
            (False, True, True, False, "bildsten", False),
        ),
    ]:
        *rates, air, slip = laws
        kernel = LOSSY_DISK.integrator(SweepSpec(**words))
        assert kernel.function == integrate.variant(*rates, tables.AIR_LAWS.index(air), slip), (words, laws)
        assert LOSSY_DISK.kernels(SweepSpec(**words)) == (kernel,), (words, laws)


def test_every_set_of_laws_has_its_kernel():
    """Every combination of laws requests a variant of the kernels, and every variant is requested."""
    asked = set()
    for *laws, air in itertools.product(*[(False, True)] * 5, tables.AIR_LAWS):
        contour, damping, rolling, pivoting, slips = laws
        kernel = variants.integrator(
            contour=contour, damping=damping, rolling=rolling, pivoting=pivoting, air=air, slips=slips
        )
        code = tables.AIR_LAWS.index(air)
        assert kernel.function == integrate.variant(contour, damping, rolling, pivoting, code, slips)
        asked.add(kernel.function)
    assert asked == set(integrate.VARIANTS)


def test_what_a_spec_without_a_title_is_about():
    """It names the motion and the losses that are present."""
    told = SweepSpec(**FULL, roll_rate=3.0, rolling_friction="0,1um").headline
    assert_facts(told, "Rolling", "rolling friction", "air", "stability", "upright")
    assert_facts(
        SweepSpec(rolling_friction=0.0, roll_rate=3.0).headline, "Rolling", "without any loss", "stability"
    )
    toy = SweepSpec.preset("toy").headline
    assert_facts(toy, "Wobbling", "contour friction", "air", "aloft")
    assert missing(toy, ["rolling friction", "pivoting friction"]) == [
        "rolling friction",
        "pivoting friction",
    ]
