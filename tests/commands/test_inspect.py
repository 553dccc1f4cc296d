"""`info`, `boundary` and `plot` report on and draw an atlas; damaged files are refused."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.atlas.reclassify import reclassify
from sweep.commands.report import boundary_table, describe
from sweep.files.reading import open_atlas

CHECKOUT = Path(__file__).parents[2]
SMALL = ["roll_rate=2:4:9", "tilt=0.1deg,1deg"]


def test_info_and_boundary_print_the_reports(command, tmp_path):
    """Standard output is the report of the atlas, or of the reclassified atlas if a criterion is given."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    with open_atlas(tmp_path / "a.nc") as atlas:
        assert command("info a.nc") == (0, describe(atlas) + "\n", "")
        assert command("boundary a.nc") == (0, boundary_table(atlas) + "\n", "")
        other = boundary_table(reclassify(atlas, "departure:1deg"))
    assert command("boundary a.nc --criterion departure:1deg") == (0, other + "\n", "")
    assert other != command("boundary a.nc")[1].strip("\n")


def test_an_expression_is_an_option_and_a_word(command, tmp_path):
    """The boundary by an expression equals that of a run with it, and the written file states the expression."""
    text = "peak_tilt > 3*tilt and nutation_period > 3s"
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    command(f"run rolling {' '.join(SMALL)} 'criterion={text}' -o own.nc")
    status, out, _ = command(f"boundary a.nc --criterion '{text}' -o b.nc")
    assert (status, out) == (0, command("boundary own.nc")[1])
    assert out != command("boundary a.nc")[1]
    assert_facts(command("info b.nc")[1], text)
    assert command("compare b.nc own.nc")[0] == 0
    assert command("verify b.nc")[0] == 0
    status, out, err = command("boundary a.nc --criterion 'friction_needed > 1' -o c.nc")
    assert (status, out) == (2, "")
    assert_facts(err, "friction_needed", "contact=yes")
    assert not (tmp_path / "c.nc").exists()


def test_an_atlas_that_is_cut(command, tmp_path):
    """Every command that reads refuses a truncated file with one message."""
    command("run rolling roll_rate=3 tilt=1deg -o a.nc")
    (tmp_path / "b.nc").write_bytes((tmp_path / "a.nc").read_bytes()[:-100])
    for line in ("info b.nc", "boundary b.nc"):
        status, out, err = command(line)
        assert (status, out) == (2, "")
        assert err.startswith("eulerdisk: b.nc: ")
        assert_facts(err, "netCDF", f"{(tmp_path / 'b.nc').stat().st_size} bytes")


@pytest.mark.slow_lane
def test_a_reader_that_leaves_early(tmp_path):
    """A pipe to a reader that closes early, like head, causes no traceback."""
    sweep.run_to_file(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg:5deg:5000"), tmp_path / "a.nc")
    process = subprocess.Popen(
        [sys.executable, "-m", "sweep", "boundary", "a.nc"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=300) == 1


def test_regimes_are_drawn(command, tmp_path):
    """`plot --regimes` draws maps of any method; a criterion or friction is refused there."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    assert command("plot a.nc --regimes -o a.png")[0] == 0
    assert (tmp_path / "a.png").stat().st_size > 10_000
    for more in ("--criterion departure:2deg", "--friction 0.5"):
        status, _, err = command(f"plot a.nc --regimes {more} -o b.png")
        assert status == 2
        assert_facts(err, "--regimes", more.split()[0])
        assert not (tmp_path / "b.png").exists()


@pytest.mark.slow_lane
def test_a_bare_figure_prints_the_text_of_its_caption(command, tmp_path):
    """A bare figure prints its caption to standard output, a full one prints nothing; unknown parts are refused."""
    sweep.save(sweep.run(sweep.SweepSpec(roll_rate="2:4:11", tilt="0.1deg:4deg:7", title="Nudged")), "a.nc")
    assert command("plot a.nc -o a.png")[:2] == (0, "")
    for words in ("--bare", "--bare --without strip,bar", "--without caption"):
        status, out, _ = command(f"plot a.nc {words} -o a.png")
        assert status == 0
        title, criterion = out.splitlines()[:2]
        assert title == "Nudged"
        assert_facts(criterion, "unstable", "departure", "5°")
    assert command("plot a.nc --without bar -o a.png")[:2] == (0, "")
    status, _, err = command("plot a.nc --without stripe -o b.png")
    assert status == 2
    assert_facts(err, "title", "caption", "legend", "bar", "stripe", "strip?")
    assert not (tmp_path / "b.png").exists()


def test_plot_takes_quantity_contours_size_and_rate(command, tmp_path):
    """The options reach the figure: the png has the requested width and resolution."""
    from matplotlib.image import imread

    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    looks = "--quantity peak_tilt --contours auto --rate squared --width 100mm --height 120mm --dpi 254 --font-size 7"
    assert command(f"plot a.nc {looks} -o a.png")[0] == 0
    assert imread(tmp_path / "a.png").shape[:2] == (1200, 1000)


@pytest.mark.parametrize(
    "line", ["info a.nc", "boundary a.nc", "export a.nc --to csv -o a.csv", "plot a.nc -o a.png"]
)
def test_what_a_user_has_added_is_left_out(command, tmp_path, line):
    """Added variables, here text and one on another dimension, are skipped and named in one line."""
    atlas = sweep.run(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate="2:3:4"))
    added = atlas.assign(remark="of June", sst=("time", [1.0, 2.0]))
    added.to_netcdf(tmp_path / "a.nc", format="NETCDF4", engine="netcdf4")
    status, _, err = command(line)
    assert status == 0
    (warning,) = (line for line in err.splitlines() if line.startswith("eulerdisk: warning: a.nc: "))
    assert_facts(warning, "remark", "1 more")
    if "csv" in line:
        head = (tmp_path / "a.csv").read_text().partition("\n")[0].split(",")
        assert not {"remark", "sst", "time"}.intersection(head)


@pytest.mark.slow_lane
def test_words_pick_a_part(command, tmp_path):
    """`boundary`, `plot` and `export` accept selections; a value off the grid is noted, and the part is an atlas."""
    command("run rolling alpha=0.5,1 roll_rate=2:4:9 tilt=0.1deg,1deg,2deg -o a.nc")
    with open_atlas(tmp_path / "a.nc") as atlas:
        part = atlas.isel(alpha=1, tilt=[1, 2]).eulerdisk.atlas
        table = boundary_table(part) + "\n"
    assert command("boundary a.nc alpha=1 tilt=1deg:3deg") == (0, table, "")
    status, out, err = command("boundary a.nc alpha=0.9 tilt=1deg:3deg -o part.nc")
    assert (status, out) == (0, table)
    assert err.startswith("eulerdisk: ")
    assert err.count("\n") == 1
    assert_facts(err, "alpha 1", "0.9")
    assert command("verify part.nc")[0] == 0
    assert command("info part.nc")[0] == 0
    assert command("plot a.nc part.nc alpha=1 -o a.png")[0] == 2
    assert command("plot a.nc alpha=1 -o a.png")[0] == 0
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert command("export a.nc alpha=1 tilt=1deg,2deg --to csv -o a.csv")[0] == 0
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1 + part.ending.size


def test_a_file_with_an_equals_sign_is_a_file(command, tmp_path):
    """A file with an equals sign in its name is recognized because it exists."""
    command(f"run rolling {' '.join(SMALL)} -o a=1.nc")
    assert command("plot a=1.nc tilt=1deg -o b.png")[0] == 0


def test_info_as_json(command, tmp_path):
    """The JSON of `info` has the same facts as plain SI values, with the counts of the cells."""
    command(f"run rolling {' '.join(SMALL)} alpha=0.5,1 boundary=refined:1e-3 -o a.nc")
    status, out, err = command("info a.nc --json")
    assert (status, err) == (0, "")
    found = json.loads(out)
    with open_atlas(tmp_path / "a.nc") as atlas:
        assert found["cells"] == atlas.ending.size == sum(found["endings"].values())
        assert found["verdicts"]["stable"] == int(atlas.eulerdisk.stable.sum())
        assert found["peak_tilt"]["largest"] == float(atlas.peak_tilt.max())
        assert {each["name"]: each for each in found["axes"]}["roll_rate"] == {
            "name": "roll_rate", "units": "rad s-1", "count": 9, "first": 2.0, "last": 4.0, "spacing": "linear",
        }  # fmt: skip
        assert found["fixed"]["radius"] == {"value": 0.5, "units": "m"}
        assert found["settings"]["step"] == {"value": "auto"}
        assert found["boundary"][0]["smallest"] == float(atlas.boundary_roll_rate.min())
        assert sum(found["boundary"][0]["rows"].values()) == atlas.boundary_roll_rate.size
        assert found["sweep_spec"] == json.loads(atlas.sweep_spec)
    assert found["history"][0].endswith("-o a.nc")


def test_info_as_json_is_for_finished_atlases(command, tmp_path):
    """`info --json` refuses an unfinished run."""
    command(f"prepare rolling {' '.join(SMALL)} -o a.nc")
    status, out, err = command("info a.nc --json")
    assert (status, out) == (2, "")
    assert_facts(err, "a.nc", "--json", "finished")


def test_the_boundary_for_programs(command, tmp_path):
    """The csv and json tables have the same rows with all digits; missing values are empty or null."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    rows = json.loads(command("boundary a.nc --to json")[1])["rows"]
    read = list(csv.DictReader(io.StringIO(command("boundary a.nc --to csv")[1])))
    assert [*rows[0]] == [*read[0]]
    for row, other in zip(rows, read, strict=True):
        assert {name: "" if value is None else str(value) for name, value in row.items()} == other
    with open_atlas(tmp_path / "a.nc") as atlas:
        measured = [np.nan if row["measured"] is None else row["measured"] for row in rows]
        np.testing.assert_array_equal(measured, atlas.boundary_roll_rate.values)
        np.testing.assert_array_equal([row["tilt"] for row in rows], atlas.tilt.values)
    other = json.loads(command("boundary a.nc --to json --criterion departure:1deg")[1])
    assert other["criterion"] == "departure:1deg"
    assert other["rows"] != rows


def test_neither_the_atlas_nor_a_table_is_replaced(command, tmp_path):
    """Output never replaces the atlas, even under another name for it, nor an existing table."""
    command("run rolling roll_rate=2:4:3 tilt=1deg -o a.nc")
    (tmp_path / "a").hardlink_to(tmp_path / "a.nc")
    (tmp_path / "a.csv").touch()
    for words, facts in (("-o a.csv", ["a.csv", "--overwrite"]), ("-o a --overwrite", ["replace", "a"])):
        status, out, err = command(f"boundary a.nc --to csv {words}")
        assert (status, out) == (2, "")
        assert_facts(err, *facts)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "a.csv", "a.nc"]


def test_the_boundary_for_programs_in_a_file(command, tmp_path):
    """With --to, -o writes the table to a file; without it, -o writes an atlas under any name."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    for kind in ("csv", "json"):
        printed = command(f"boundary a.nc --criterion departure:1deg --to {kind}")[1]
        line = f"boundary a.nc --criterion departure:1deg --to {kind} -o b.{kind}"
        assert command(line) == (0, "", "")
        assert (tmp_path / f"b.{kind}").read_text() == printed
        assert command(line)[0] == 2
        assert command(f"{line} --overwrite")[0] == 0
    for name in ("b", "b.NC4", "b-0.5", "b.h5"):
        assert command(f"boundary a.nc -o {name}")[0] == 0
        assert command(f"info {name}")[0] == 0


def test_export_says_what_it_wrote(command, tmp_path):
    """Each exported file is named: the cells and, for csv, the boundary if there is one."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    command("run rolling roll_rate=3 tilt=1deg -o one.nc")
    status, out, err = command("export a.nc --to csv")
    assert (status, out) == (0, "")
    cells, boundary = err.splitlines()
    assert_facts(cells, "a.csv", "18 cells")
    assert boundary.startswith("eulerdisk: a.boundary.csv: ")
    status, out, err = command("export one.nc --to csv")
    assert (status, out, err.count("\n")) == (0, "", 1)
    assert_facts(err, "one.csv", "1 cell")
    assert sorted(path.name for path in tmp_path.glob("*.csv")) == ["a.boundary.csv", "a.csv", "one.csv"]
    assert "OUT.boundary.csv" in command("export --help")[1]


def test_info_tells_what_an_option_has_added_and_on_which_terms(command, tmp_path):
    """The results of contact=yes and the license and citation are in both text and JSON."""
    command(f"run rolling {' '.join(SMALL)} contact=yes -o a.nc")
    command(f"run rolling {' '.join(SMALL)} -o b.nc")
    words, found = command("info a.nc")[1], json.loads(command("info a.nc --json")[1])
    with open_atlas(tmp_path / "a.nc") as atlas:
        force, friction = float(atlas.least_normal_force.min()), float(atlas.friction_needed.max())
        added = [line for line in words.splitlines() if line.startswith("added")]
        assert any(f": {force:.6g} to " in line for line in added)
        assert any(line.endswith(f" to {friction:.6g}") for line in added)
        assert any(line.endswith(": 18 presses") for line in added)
        assert (
            found["added"]["least_normal_force"]["smallest"],
            found["added"]["contact_state"]["presses"],
        ) == (force, 18)
        assert f"license     {atlas.license}\ncitation    {atlas.citation}\n" in words
        assert (found["license"], found["citation"]) == (atlas.license, atlas.citation)
    assert "added" not in command("info b.nc")[1]
    assert json.loads(command("info b.nc --json")[1])["added"] == {}
