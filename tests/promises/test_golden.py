"""The project's reference atlases: each release must reproduce them.

They prove sameness, not truth: for that see tests/kernels. Each file's history has the command that made it;
``pytest tests/promises/test_golden.py --eulerdisk-regen`` regenerates them.
"""

from pathlib import Path

import pytest

import sweep
from sweep.atlas.dataset import spec_of

DATA = Path(__file__).with_name("data")

#: Released and kicked, rolling, spinning and circling, with falls, and a cube of disks and hoops.
GOLDEN = {
    "rolling.nc": "rolling roll_rate=1:4:13 tilt=0.01deg:40deg:10:log",
    "spinning.nc": "spinning alpha=1 precession_rate=2:6:13 tilt=0.01deg:40deg:10:log",
    "circling.nc": "circling precession_rate=0.05:5:12 tilt=1deg:25deg:9",
    "kicked.nc": "rolling tilt=0 tilt_rate=0.01:10:4:log roll_rate=8:20:9 alpha=0.3,0.5,1 "
    "criterion=amplification:10 fall_tilt=60deg radius=2cm duration=0.5s",
}


@pytest.mark.parametrize("name", GOLDEN)
def test_golden(eulerdisk_atlas, name):
    """The command reproduces the atlas in the file, within the tolerances of the tables."""
    eulerdisk_atlas(GOLDEN[name], f"data/{name}")


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_file_says_how_it_was_made(name):
    """The file contains its command and its spec, and is small."""
    with sweep.open_atlas(DATA / name) as atlas:
        assert f"Z eulerdisk run {GOLDEN[name]} -o data/{name}" in atlas.attrs["history"]
        spec = sweep.SweepSpec.from_words(GOLDEN[name].split()[0], GOLDEN[name].split()[1:])
        assert spec_of(atlas) == spec
        assert atlas.attrs["title"] == spec.headline
    assert (DATA / name).stat().st_size < 120_000


def test_golden_atlases_hold_every_kind_of_cell():
    """Together they have stable, unstable and undecided cells, and bounded, falling and cut-off ones."""
    found = {"ending": set(), "stability": set()}
    for name in GOLDEN:
        with sweep.open_atlas(DATA / name) as atlas:
            for flag, seen in found.items():
                meanings = atlas[flag].attrs["flag_meanings"].split()
                seen |= {meanings[code] for code in atlas[flag].values.flat}
    assert found["stability"] == {"undecided", "stable", "unstable"}
    assert found["ending"] >= {"bounded", "fell", "horizon"}


def test_there_is_no_other_file():
    """These tests check every file of the folder."""
    assert {path.name for path in DATA.iterdir()} == set(GOLDEN)
