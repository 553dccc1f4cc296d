"""dataset.eulerdisk: it exists for any import order, and gives the right answers."""

import importlib
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import cf_xarray  # noqa: F401  (registers the accessor .cf)
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, refused, with_facts
from PIL import Image

import sweep
from sweep.figures import plots
from sweep.figures.disk.regimes import NAMES
from sweep.figures.look import Look
from sweep.model.disk.tables import VARIABLES

CHECKOUT = Path(__file__).parents[1]
SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg:30deg:5:log")
CIRCLING = sweep.SweepSpec.preset("circling").replace(tilt="5deg:15deg:3", precession_rate="0.1:5:12")


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas of released disks."""
    return sweep.run(SPEC)


@pytest.mark.slow_lane
def test_the_accessor_is_there_in_any_order():
    """Once both packages are imported, datasets have the accessor; xarray and the import system are unchanged."""
    for imports in [
        "import sweep, xarray as xr",
        "import xarray as xr, sweep",
        "import sweep, importlib.util; importlib.util.find_spec('xarray'); import xarray as xr",
        "import sweep; from xarray.core import dataset; import xarray as xr",
        "import sweep, importlib, xarray as xr; importlib.reload(sweep)",
        "import sweep.cli, xarray as xr",
    ]:
        check = (
            "; import sys; print(xr.Dataset.eulerdisk.__name__, type(xr.__loader__).__name__,"
            " [each.name for each in sys.meta_path if type(each).__module__.startswith('sweep')],"
            " 'exec_module' in vars(xr.__loader__))"
        )
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", imports + check],
            env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
            capture_output=True,
            text=True,
            check=False,
        )
        # Numba has not been imported yet.
        assert done.stdout == "Eulerdisk SourceFileLoader [] False\n", done.stderr


def test_a_failed_import_stays_what_it_is(monkeypatch, tmp_path):
    """A failing module raises its own error, and is watched only once."""
    from sweep.import_hook import when_imported

    called = []
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "breaks.py").write_text("1 / 0\n")
    (tmp_path / "works.py").write_text("answer = 42\n")
    before = list(sys.meta_path)
    when_imported("breaks", lambda: called.append("breaks"))
    when_imported("works", lambda: called.append("works"))
    when_imported("no_such_module", lambda: called.append("none"))
    for name, error in (("breaks", ZeroDivisionError), ("no_such_module", ModuleNotFoundError)):
        with pytest.raises(error):
            importlib.import_module(name)
    assert importlib.import_module("works").answer == 42
    assert called == ["works"]
    when_imported("works", lambda: called.append("again"))
    assert called == ["works", "again"]
    monkeypatch.delitem(sys.modules, "works")
    sys.meta_path[:] = before


def test_verdicts_are_masks(atlas):
    """`stable` and `unstable` are the flags as booleans; cf-xarray decodes the same from the file's attributes."""
    mine = atlas.eulerdisk
    np.testing.assert_array_equal(mine.stable, atlas["stability"] == 1)
    np.testing.assert_array_equal(mine.unstable, atlas["stability"].values == 2)
    assert mine.stable.dtype == bool
    assert 0 < int(mine.stable.sum()) < SPEC.size
    np.testing.assert_array_equal(atlas["stability"].cf == "stable", mine.stable)
    np.testing.assert_array_equal(atlas["ending"].cf == "bounded", atlas["ending"] == 1)
    part = atlas.isel(tilt=slice(2))
    np.testing.assert_array_equal(part.eulerdisk.stable, part["stability"] == 1)


def test_cells_to_trust_are_a_mask(atlas):
    """The mask covers known endings, and numbers known to within an error; giving only part of that is refused."""
    ending = atlas.ending.copy(data=atlas.ending.values.copy())
    endings = atlas.eulerdisk.spec.model.endings
    ending.values[0, 0], ending.values[1, 0] = endings.code("not_computed"), endings.code("unresolved")
    known = atlas.assign(ending=ending).eulerdisk.trusted()
    assert known.dims == atlas.ending.dims
    assert np.argwhere(~known.values).tolist() == [[0, 0], [1, 0]]
    rule = VARIABLES["tilt_max"].tolerance
    allowed = 2.0 * atlas.tilt_error.values + rule.absolute + rule.relative * np.abs(atlas.tilt_max.values)
    middle = float(np.median(allowed))
    for within in (0.0, middle, 1.0):
        found = atlas.eulerdisk.trusted("tilt_max", within=within)
        assert np.array_equal(found.values, allowed <= within)
        assert found.values.mean() == pytest.approx({0.0: 0.0, middle: 0.5, 1.0: 1.0}[within], abs=0.1)
    for wrong in (("tilt_max",), ("stability", 1.0), (None, 1.0), ("tilt_max", -1.0), ("nothing", 1.0)):
        with refused("within", "tilt_max"):
            atlas.eulerdisk.trusted(*wrong[:1], within=wrong[1] if len(wrong) > 1 else None)


def test_boundaries_and_critical_rates(atlas):
    """The boundary has short names; the critical rate of a rolling disk is sqrt(g/3R)."""
    found = atlas.eulerdisk.boundary()
    assert list(found) == ["measured", "halfwidth", "predicted", "critical", "status"]
    np.testing.assert_array_equal(found["measured"], atlas["boundary_roll_rate"])
    np.testing.assert_array_equal(found["predicted"], atlas["predicted_roll_rate"])
    np.testing.assert_allclose(atlas.eulerdisk.critical, np.sqrt(9.81 / (3 * 0.5)), rtol=1e-15)
    circling = sweep.run(CIRCLING)
    lower = circling.eulerdisk.boundary("precession_rate", "lower")
    np.testing.assert_array_equal(lower["measured"], circling["boundary_lower_precession_rate"])
    for words, given in (({"axis": "tilt"}, "tilt"), ({"edge": "lower"}, "lower")):
        with refused("boundary_roll_rate", given):
            atlas.eulerdisk.boundary(**words)


def test_a_cell_is_the_nearest(atlas):
    """A cell is selected by values with units, nearest along each axis, by logarithm on logarithmic axes."""
    tilts = np.degrees(atlas["tilt"].values)
    # Between the arithmetic and the geometric mean of two tilts, the larger is nearer by logarithm.
    between = 0.5 * (np.sqrt(tilts[2] * tilts[3]) + 0.5 * (tilts[2] + tilts[3]))
    cell = atlas.eulerdisk.cell(roll_rate=2.4, tilt=f"{between}deg")
    assert cell.sizes == {}
    np.testing.assert_array_equal(cell["tilt_max"], atlas["tilt_max"].values[2, 3])
    assert float(cell["roll_rate"]) == 2.5
    assert "boundary_roll_rate" not in cell


def test_no_cell_is_refused(atlas):
    """A missing axis, an outside value, another disk and an unknown word are refused with what the atlas has."""
    for given, facts in [
        ({"roll_rate": 2.4}, ["tilt=1.73deg"]),
        ({"roll_rate": 9, "tilt": "1deg"}, ["roll_rate=9", "2 rad s-1", "4 rad s-1"]),
        ({"roll_rate": 2.4, "tilt": "1deg", "alpha": 1}, ["alpha=1", "0.5"]),
        ({"rol_rate": 2.4, "tilt": "1deg"}, ["rol_rate", "roll_rate?"]),
        ({"roll_rate": "2.4m", "tilt": "1deg"}, ["roll_rate=2.4m", "rad/s", "rpm"]),
    ]:
        with refused(*facts):
            atlas.eulerdisk.cell(**given)


def test_the_rate_that_is_computed_names_no_cell():
    """In an atlas of circling disks the roll rate follows from the cell."""
    with refused("roll_rate=1", "computed", "tilt, precession_rate"):
        sweep.run(CIRCLING).eulerdisk.cell(roll_rate=1, tilt="5deg", precession_rate=1)


def test_another_criterion_and_a_figure(atlas):
    """`reclassify` equals the package's function; `plot` returns a figure with the map."""
    other = atlas.eulerdisk.reclassify("departure:1deg")
    xr.testing.assert_equal(other, sweep.reclassify(atlas, "departure:1deg"))
    assert atlas.eulerdisk.spec == SPEC
    assert atlas.eulerdisk.plot().axes


def test_a_few_lines_say_what_it_is(atlas):
    """Text and HTML show title, axes, criterion, counts and boundary, and escape HTML."""
    text = repr(atlas.eulerdisk)
    stable, unstable = int(atlas.eulerdisk.stable.sum()), int(atlas.eulerdisk.unstable.sum())
    assert len(text.splitlines()) == 10
    for part in (
        "Rolling along a line",
        "9 x 5 = 45 cells",
        "roll_rate 9: 2 to 4 rad s-1",
        "tilt 5: 0.1 to 30 deg, logarithmic",
        "alpha 0.5, radius 0.5 m, gravity 9.81 m s-2",
        "departure:5deg",
        f"{stable} stable ({100 * stable / 45:.3g} %), {unstable} unstable ({100 * unstable / 45:.3g} %)",
    ):
        assert part in text
    assert "boundary_roll_rate" in text
    odd = atlas.assign_attrs(title="a < b & <script>")
    assert ">a &lt; b &amp; &lt;script&gt;</td>" in odd.eulerdisk._repr_html_()


def test_another_dataset_has_it_and_says_what_is_wrong():
    """For a dataset that is no atlas the repr says so, and every query is refused with the remedy."""
    foreign = xr.Dataset({"sst": ("x", [1.0])})
    assert repr(foreign.eulerdisk).startswith("eulerdisk  not ")
    for ask in (
        lambda it: it.stable,
        lambda it: it.critical,
        lambda it: it.cell(tilt=1),
        lambda it: it.plot(),
    ):
        with refused("sweep_spec", "dataset of sst", "keep_attrs=True"):
            ask(foreign.eulerdisk)


def test_what_lies_between_cells_says_so(atlas):
    """The package itself dropped the attributes, so the advice is not to keep them."""
    between = atlas.eulerdisk.interp(tilt="1.1deg")
    with refused("eulerdisk.interp", "dataset.to_netcdf") as caught:
        between.eulerdisk.plot()
    assert "keep" not in str(caught.value)


def test_places_outside_are_refused_by_the_words_given(atlas):
    """The message has their unit, and limits that are inside."""
    for words, facts in [
        ({"inclination": "50deg"}, ["inclination=50deg", "tilt", "0.1 deg", "30 deg"]),
        ({"inclination": 1.0}, ["inclination=1.0", "tilt", "0.001745329252 rad", "0.5235987755 rad"]),
        ({"tilt": 2.0}, ["tilt=2.0", "radians", "tilt=2.0deg"]),
        ({"speed": "90m/s"}, ["speed=90m/s", "roll_rate", "2 rad s-1", "4 rad s-1"]),
    ]:
        with refused(*facts) as caught:
            atlas.eulerdisk.interp(**words)
        if words == {"tilt": 2.0}:
            limits = re.findall(r"([\d.]+) rad", caught.value.message)
            assert len(atlas.eulerdisk.interp(tilt=[float(each) for each in limits]).tilt) == 2


def test_the_order_of_the_dimensions_does_not_matter(atlas):
    """A transposed atlas gives the same verdicts, cells and boundaries."""
    turned = atlas.transpose(*reversed(atlas.ending.dims))
    there, here = (each.eulerdisk.reclassify("departure:2deg") for each in (atlas, turned))
    xr.testing.assert_equal(here, there)
    given = {name: float(atlas[name][1]) for name in atlas.ending.dims}
    xr.testing.assert_equal(turned.eulerdisk.cell(**given), atlas.eulerdisk.cell(**given))
    xr.testing.assert_equal(sweep.reclassify(turned, "departure:2deg"), there)


def test_words_of_a_file_are_text(atlas):
    """A file's title is shortened and shown without control characters; HTML in it is escaped."""
    named = atlas.assign_attrs(title="<b>\x1b[31m" + "x" * 1000)
    assert "<b>\\x1b[31mxxx" in repr(named.eulerdisk)
    assert len(repr(named.eulerdisk).splitlines()[0]) < 120
    assert "&lt;b&gt;" in named.eulerdisk._repr_html_()


@pytest.fixture(scope="module")
def fall():
    """Return the motion of a coin that falls in place."""
    return sweep.simulate(radius="12mm", tilt="1deg", duration=2.0)


def test_a_motion_is_drawn_and_filmed(fall, tmp_path):
    """A motion from `simulate` has a figure and a film; an existing film is replaced only on request."""
    assert len(fall.eulerdisk.plot().axes) == 4
    film = tmp_path / "fall.gif"
    fall.isel(elapsed_time=slice(900, None)).eulerdisk.animate(film, speed=0.1, fps=10, size=(200, 200))
    with Image.open(film) as read:
        # 0.02 s at a tenth of the speed and 10 frames per second.
        assert (read.size, read.n_frames) == ((200, 200), 4)
    before = film.read_bytes()
    with refused(str(film), "--overwrite"):
        fall.eulerdisk.animate(film)
    assert film.read_bytes() == before
    fall.eulerdisk.animate(film, speed=1.0, fps=10, size=(200, 200), overwrite=True)
    assert film.read_bytes() != before


def test_a_motion_says_what_it_is(fall):
    """It shows disk, start, duration, fall, and when rolling becomes impossible; an incomplete motion says so."""
    lines = repr(fall.eulerdisk).splitlines()
    assert [line.split()[0] for line in lines] == ["motion", "disk", "time", "contact"]
    assert_facts(lines[1], "R = 12 mm", "α = 0.5", "tilt 1 deg")
    assert_facts(lines[2], "fell", "0.202681 s")
    assert re.search(r"slips .*0\.18\d* s", lines[3])
    assert "contact_x" in repr(fall.drop_vars("contact_x").eulerdisk)
    assert re.search(r"needs 0\.45", repr(sweep.simulate(tilt_rate=0.01, roll_rate=2.0).eulerdisk))
    assert "<th" in fall.eulerdisk._repr_html_()


def test_a_motion_with_losses_says_where_its_energy_went():
    """It shows its end, each law's share of the losses, and that it always rolls."""
    motion = sweep.simulate("toy", tilt="80deg")
    lines = repr(motion.eulerdisk).splitlines()
    assert [line.split()[0] for line in lines] == ["motion", "disk", "time", "losses", "contact"]
    assert_facts(lines[2], "flat", f"{float(motion['end_time']):.6g} s")
    lost = {name: float(motion[name][-1]) for name in ("contour_loss", "air_loss")}
    share = lost["contour_loss"] / sum(lost.values())
    assert_facts(
        lines[3],
        f"{sum(lost.values()):.4g} J",
        f"contour friction {100.0 * share:.1f} %",
        f"air {100.0 * (1 - share):.1f} %",
    )
    assert_facts(lines[4], "rolls")
    assert "losses" not in repr(sweep.simulate(tilt=0.1, duration=0.1).eulerdisk)


def test_a_map_of_losses_is_a_word_of_plot():
    """It cannot be combined with other options, and a motion has no map."""
    atlas = sweep.run("toy", tilt="60deg,80deg", precession_rate="60,80")
    assert_facts(atlas.eulerdisk.plot(losses=True).axes[-1].get_ylabel(), "aloft", "(s)")
    with refused("losses", "quantity", "family"):
        atlas.eulerdisk.plot(losses=True, quantity="steps", family=True)
    with refused("losses", "map"):
        sweep.simulate(duration=0.1).eulerdisk.plot(losses=True)


def test_a_map_of_regimes_is_a_word_of_plot():
    """It equals the command's map and cannot be combined with other options."""
    atlas = sweep.run("rolling", tilt="1deg,20deg", roll_rate="1,3")
    legend = atlas.eulerdisk.plot(regimes=True).axes[0].get_legend()
    shown = [" ".join(text.get_text().split()) for text in legend.get_texts()]
    folds = with_facts(shown, "fold", "theory")
    regions = {*shown} - {*folds}
    assert regions
    assert regions <= {each.replace("\n", ", ") for each in NAMES}
    with refused("regimes", "friction", "losses"):
        atlas.eulerdisk.plot(regimes=True, friction=0.3, losses=True)


@pytest.mark.parametrize(
    ("ask", "facts"),
    [
        (lambda motion: motion.eulerdisk.stable, ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.boundary(), ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.spec, ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.cell(tilt=0.1), ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.atlas, ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.interp(tilt=0.1), ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.simulate(tilt=0.1), ["motion", "plot", "animate"]),
        (lambda motion: motion.eulerdisk.reclassify("departure:2deg"), ["motion", "plot", "animate"]),
        (lambda motion: motion.isel(elapsed_time=0).eulerdisk.plot(), ["two samples"]),
        (lambda motion: motion.drop_vars("radius").eulerdisk.animate("a.gif"), ["missing", "radius"]),
        (lambda motion: motion.eulerdisk.animate("a.gif", speed=0), ["speed", "1e-09", "1e+09", "0"]),
        (lambda motion: motion.eulerdisk.animate("a.avi"), ["a.avi", ".mp4", ".gif"]),
        (lambda motion: motion.eulerdisk.animate("absent/a.gif"), ["absent/a.gif", "mkdir -p absent"]),
        (lambda motion: xr.Dataset({"a": 1}).eulerdisk.animate("a.gif"), ["motion"]),
    ],
)
def test_what_a_motion_cannot_be_asked(fall, ask, facts, tmp_path, monkeypatch):
    """The query is refused, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    with refused(*facts):
        ask(fall)
    assert list(tmp_path.iterdir()) == []


def test_an_atlas_is_no_film(atlas):
    """The refusal says how to film the motion of a cell."""
    with refused(
        "motion", "atlas.eulerdisk.simulate(roll_rate=3.0, tilt=0.030229989403903628).eulerdisk.animate(path)"
    ):
        atlas.eulerdisk.animate("a.gif")


def test_words_of_a_plot_that_cannot_be_are_refused(atlas):
    """The message names the argument, its range and the given value."""
    for words, facts in [
        ({"friction": "x"}, ["friction", "0", "x"]),
        ({"friction": -1}, ["friction", "0", "-1"]),
        ({"friction": float("nan")}, ["friction", "0", "nan"]),
        ({"ax": 3}, ["ax", "Axes", "matplotlib"]),
        ({"font_size": "x"}, ["font_size=x"]),
    ]:
        with refused(*facts):
            atlas.eulerdisk.plot(**words)


def test_every_word_of_a_figure_reaches_it(atlas, monkeypatch):
    """`plot` passes on each of its arguments by name, to the look, the friction or the axes."""
    words = {name: object() for name in inspect.signature(sweep.Eulerdisk.plot).parameters if name != "self"}
    words |= {"losses": False, "regimes": False}
    taken = {}

    def figure(_, friction, look, ax):
        taken.update(look, friction=friction, ax=ax)

    monkeypatch.setattr(Look, "read", lambda **given: given)
    monkeypatch.setattr(plots, "figure", figure)
    atlas.eulerdisk.plot(**words)
    assert taken == {name: value for name, value in words.items() if value is not False}
