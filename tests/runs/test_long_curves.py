"""Curves with more points than memory is to hold: the same file, whatever ends the run on the way."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

import sweep
from sweep.atlas import chains, neighbours, scratch
from sweep.checks.verify import findings_of
from sweep.errors import StorageError

pytestmark = pytest.mark.compiled

#: Planes with open curves and closed ones.
SPEC = sweep.SweepSpec(
    alpha="0.5,1",
    roll_rate="-4:4:23",
    tilt="-3deg:3deg:20",
    criterion="peak_tilt > 4deg and roll_rate < -1 or roll_rate > 0.5 and roll_rate < 2.1 "
    "and tilt > 0.5deg and tilt < 2deg",
    boundary="refined:1e-3",
)

#: Squares, pages and points of which some are many here.
FEW = {"neighbours._AT_ONCE": 50, "chains._PAGE_BITS": 2, "chains._MOST_PAGES": 2, "scratch._MOST_HELD": 64}


@pytest.fixture(scope="module", name="expected")
def _expected(tmp_path_factory):
    """The file of an undisturbed run that needs no disk for its curves."""
    path = tmp_path_factory.mktemp("undisturbed") / "a.nc"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1700000000")
        sweep.run_to_file(SPEC, path)
    return path.read_bytes()


@pytest.fixture(autouse=True)
def _few(monkeypatch):
    """Let little be much."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    modules = {"neighbours": neighbours, "chains": chains, "scratch": scratch}
    for name, value in FEW.items():
        module, _, constant = name.partition(".")
        monkeypatch.setattr(modules[module], constant, value)


def test_the_file_is_the_same(expected, tmp_path, monkeypatch):
    """To the byte; the points were in the folder of the run."""
    folders, open_scratch = [], scratch.open_scratch
    monkeypatch.setattr(
        scratch, "open_scratch", lambda folder: folders.append(folder) or open_scratch(folder)
    )
    sweep.run_to_file(SPEC, tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_bytes() == expected
    assert set(folders) == {tmp_path.resolve() / "a.nc.run"}
    assert os.listdir(tmp_path) == ["a.nc"]
    with sweep.open_atlas(tmp_path / "a.nc") as atlas:
        assert atlas.sizes["curve"] > 2
        assert 0 < int(atlas["curve_closed"].sum()) < atlas.sizes["curve"]


def test_verify_finds_the_same(tmp_path):
    """What it finds again with few points in memory is what the run has found."""
    sweep.run_to_file(SPEC, tmp_path / "a.nc")
    with sweep.open_atlas(tmp_path / "a.nc") as atlas:
        statements = {each.name: each for each in findings_of(atlas).statements}
        assert statements["curve_tilt"].judged == atlas.sizes["curve_point"]
        assert statements["curve_tilt"].wrong == statements["curve_point_count"].wrong == 0


def test_no_room_for_the_points(expected, tmp_path, monkeypatch):
    """A full disk is told in a sentence, no block is lost, and the next run makes the file."""

    def refuse(folder):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))

    with monkeypatch.context() as patch:
        patch.setattr(scratch, "open_scratch", refuse)
        with pytest.raises(StorageError, match=r"no room left.*kept"):
            sweep.run_to_file(SPEC, tmp_path / "a.nc")
    assert os.listdir(tmp_path) == ["a.nc.run"]
    said = []
    sweep.run_to_file(SPEC, tmp_path / "a.nc", say=said.append)
    assert any("0 to compute" in each for each in said)
    assert (tmp_path / "a.nc").read_bytes() == expected


@pytest.mark.parametrize("writes", [1, 10, 40])
def test_killed_while_points_are_written(expected, tmp_path, writes):
    """A kill -9 while curves are followed leaves the blocks and no other file; the next run makes the same file."""
    script = (
        "import os, signal, sys, sweep\n"
        "from sweep.atlas import chains, neighbours, scratch\n"
        + "".join(f"{name} = {value}\n" for name, value in FEW.items())
        + "put, left = scratch.Column._put, [int(sys.argv[2])]\n"
        "def counted(*given):\n"
        "    put(*given)\n"
        "    left[0] -= 1\n"
        "    left[0] or os.kill(os.getpid(), signal.SIGKILL)\n"
        "scratch.Column._put = counted\n"
        "sweep.run_to_file(sweep.SweepSpec.read(sys.argv[3]), sys.argv[1])\n"
    )
    (tmp_path / "spec.toml").write_text(SPEC.to_toml())
    path = tmp_path / "a.nc"
    command = [sys.executable, "-c", script, str(path), str(writes), str(tmp_path / "spec.toml")]
    assert subprocess.run(command, cwd=Path(__file__).parents[2], check=False).returncode == -9
    folder = tmp_path / "a.nc.run"
    assert not [each for each in os.listdir(folder) if each.endswith(".tmp")]
    said = []
    sweep.run_to_file(SPEC, path, say=said.append)
    assert any("0 to compute" in each for each in said)
    assert path.read_bytes() == expected
