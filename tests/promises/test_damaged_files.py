"""For any input file a command ends with a documented status and message: the short form of scripts/fuzz."""

import os
import random
import shlex
import sys

import damage
import foreign_files
import fuzz
import netCDF4
import odd_words
import pytest
from messages import assert_facts

import sweep
from sweep import cli

#: The atlases with the most kinds of variables among those that scripts/fuzz damages.
WHOLE = ("rolling.nc", "curves.nc", "random.nc")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with undamaged atlases."""
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "OUT").mkdir()
    for name in WHOLE:
        preset, *changes = shlex.split(fuzz.WHOLE[name])
        sweep.run_to_file(sweep.SweepSpec.from_words(preset, changes), folder / name)
    return folder


@pytest.fixture
def ended(folder, monkeypatch, capfd):
    """Return a function that runs a command line in the folder of atlases and returns how it ended."""
    monkeypatch.chdir(folder)

    def run(line):
        monkeypatch.setattr(sys, "argv", ["eulerdisk", *line])
        began = sum(os.times()[:4])
        with pytest.raises(SystemExit) as end:
            cli.main()
        out, err = capfd.readouterr()
        return fuzz.End(end.value.code or 0, out, err, sum(os.times()[:4]) - began, 0)

    return run


@pytest.fixture
def dice(rng):
    """Return a generator of the standard library, as scripts/fuzz uses."""
    return random.Random(int(rng.integers(2**32)))


def judged(ended, name, *lines):
    """Run command lines that read a file, check that all end properly, and return how."""
    ends = [ended(line.format(name).split()) for line in lines]
    assert [found for end in ends for found in fuzz.faults(end)] == [], (name, lines)
    return ends


def test_damaged_bytes(folder, ended, dice):
    """A file with changed, truncated, moved or added bytes is read or refused."""
    for way in damage.BYTES:
        path = folder / f"{way.__name__}.nc"
        path.write_bytes(way(bytearray((folder / dice.choice(WHOLE)).read_bytes()), dice))
        judged(ended, path.name, "compare rolling.nc {}")


@pytest.mark.release
def test_edited_structure(folder, ended, dice):
    """A file with other variables, dimensions, attributes or values than an atlas is read or refused."""
    for way in damage.EDITS:
        path = folder / f"{way.__name__}.nc"
        path.write_bytes((folder / dice.choice(WHOLE)).read_bytes())
        damage.edit(path, [way], dice)
        judged(ended, path.name, "boundary {}", "explain {} tilt=2deg roll_rate=2.5")


def test_foreign_files(folder, ended, dice):
    """Files of other tools, folders, pipes and devices are refused."""
    for number, make in enumerate(foreign_files.FOREIGN):
        make(folder / f"foreign{number}.nc", dice)
        found, _ = judged(ended, f"foreign{number}.nc", "info {}", "plan {} --no-calibrate")
        assert found.status == 2, number


def test_odd_spec_files(folder, ended, dice):
    """A spec file with any content, or something that is no file, is read or refused."""
    for number, (_, make, *_) in enumerate(odd_words.FILES):
        make(folder / f"odd{number}.toml", dice)
        judged(ended, f"odd{number}.toml", "plan {} --no-calibrate")


def test_odd_words(ended, dice):
    """A request with odd words is executed or refused."""
    for line in (odd_words.words(dice) for _ in range(12)):
        if line[0] != "simulate":
            assert fuzz.faults(ended(line)) == [], line


def test_more_cells_than_bytes_are_refused(folder, ended):
    """A file of some kilobytes that declares 2**30 values is refused before memory is allocated."""
    path = folder / "empty.nc"
    path.write_bytes((folder / "rolling.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("much", 2**30)
        file.createVariable("much", "f8", ("much",), chunksizes=(2**16,))
    end = ended(["info", path.name])
    assert (end.status, end.out) == (2, "")
    assert_facts(end.err, path.name, "much", "values", "bytes")


def test_a_missing_part_of_a_boundary_is_named(folder, ended):
    """The four variables of an edge belong together; every command names a missing one."""
    path = folder / "half.nc"
    path.write_bytes((folder / "rolling.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.renameVariable("boundary_roll_rate_halfwidth", "other")
    for line in ("info half.nc", "boundary half.nc", "compare rolling.nc half.nc", "export half.nc --to csv"):
        end = ended(line.split())
        assert (end.status, end.out) == (2, "")
        assert_facts(end.err, "boundary_roll_rate_halfwidth")


def test_texts_of_a_file_do_not_reach_the_terminal_raw(folder, ended):
    """Control sequences, markup and a title of a megabyte are shown as text of a reasonable length."""
    path = folder / "words.nc"
    path.write_bytes((folder / "rolling.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.title = "[red]a\x1b[31mb\x9b" + "x" * 2**20
        file.history = "line\n" * 1000
        file.source = "\u202egnp"
    end = ended(["info", path.name])
    assert end.status == 0
    assert fuzz.faults(end) == []
    assert end.out.startswith("[red]a\\x1b[31mb\\x9bxxx")
    assert "\\u202egnp" in end.out
    assert len(end.out) < 5000
    end = ended(["info", "no\x1b[31msuch\n.nc"])
    assert end.status == 2
    assert end.err.startswith("eulerdisk: no\\x1b[31msuch\\n.nc: ")
