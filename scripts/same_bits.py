"""Compute a dozen small atlases with another checkout and with this one, and print the differences.

    python scripts/same_bits.py ../before

For a change that should not alter any number, compare with the state before it: `git worktree add ../before COMMIT`.
The atlases include every kind of cell: presets, refined boundaries on one to four axes, losses, random starts, the
exact method, contact forces and a single cell. The hash of the code and the history may differ; exit status 1 if
anything else does.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import netCDF4
import numpy as np

#: Name of an atlas -> its words.
ATLASES = {
    "rolling": "rolling roll_rate=1:4:60 tilt=0.01deg:40deg:50:log boundary=refined:1e-6",
    "spinning": "spinning precession_rate=1:6:70 tilt=0.01deg:70deg:60 boundary=refined:1e-5",
    "circling": "circling precession_rate=0.05:5:60 tilt=1deg:60deg:40 boundary=refined:1e-4 duration=20s",
    "three-axes": "rolling roll_rate=1:4:20 tilt=0.1deg:40deg:15:log alpha=0.4,0.7,1 boundary=refined:1e-4",
    "two-rates": "rolling precession_rate=-3:3:25 roll_rate=-4:4:31 tilt=10deg boundary=refined:1e-4 "
    "criterion=departure:20deg",
    "four-axes": "rolling alpha=0.3:1:7 roll_rate=-4:4:41 precession_rate=-2:2:9 tilt=5deg,20deg "
    "boundary=refined:1e-3 criterion=amplification:3",
    "one-axis": "rolling roll_rate=2:4:200",
    "random": "rolling samples=500 seed=3 tilt=uniform:1deg:5deg roll_rate=uniform:2:4",
    "toy": "toy tilt=60deg:85deg:6 contour_friction=5um:50um:4:log precession_rate=wobble",
    "coin": "coin roll_rate=15:80:9 rolling_friction=1um:1mm:7:log boundary=refined:0.01",
    "exact": "spinning method=exact precession_rate=1:6:40 tilt=0.01deg:70deg:30",
    "contact": "rolling contact=yes roll_rate=1:4:20 tilt=1deg:40deg:15",
    "cell": "rolling tilt=1deg roll_rate=3",
}

#: Attributes that another code or another command may change.
_FREE = ("kernel_hash", "history", "requested_as")


def main() -> int:
    """Compute, compare, and return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("other", type=Path, help="the other checkout")
    parser.add_argument(
        "--only", nargs="*", choices=ATLASES, default=[*ATLASES], help="compute only these atlases"
    )
    given = parser.parse_args()
    here, found = Path(__file__).resolve().parents[1], 0
    with tempfile.TemporaryDirectory() as folder:
        for name in given.only:
            before, now = (
                compute(checkout, name, Path(folder) / f"{name}-{number}.nc")
                for number, checkout in enumerate((given.other.resolve(), here))
            )
            for sentence in differences(before, now):
                found += 1
                print(f"{name}: {sentence}")
    print(f"{found} differences in {len(given.only)} atlases")
    return 1 if found else 0


def compute(checkout: Path, name: str, path: Path) -> Path:
    """Compute an atlas with the code of a checkout; return `path`, its file."""
    words = [sys.executable, "-m", "sweep", "run", "-q", *ATLASES[name].split(), "-o", str(path)]
    environment = {**os.environ, "PYTHONPATH": str(checkout), "SOURCE_DATE_EPOCH": "0"}
    subprocess.run(words, cwd=path.parent, env=environment, check=True)
    return path


def differences(before: Path, now: Path) -> Iterator[str]:
    """Yield a sentence for each variable and attribute that is not identical in two files."""
    with netCDF4.Dataset(before) as one, netCDF4.Dataset(now) as other:
        for file in (one, other):
            file.set_auto_mask(False)
        for name in sorted({*one.variables} | {*other.variables}):
            if name not in one.variables or name not in other.variables:
                yield f"only {'the other' if name in one.variables else 'this'} checkout writes {name}"
                continue
            old, new = (np.asarray(file[name][...]) for file in (one, other))
            if (old.dtype, old.shape) != (new.dtype, new.shape):
                yield f"{name} is {old.dtype} of shape {old.shape} there, {new.dtype} of shape {new.shape} here"
            elif old.tobytes() != new.tobytes():
                yield f"{name} has different bits in {int((old != new).sum())} of {old.size} values"
            yield from _attributes(one[name], other[name], f"of {name}")
        yield from _attributes(one, other, "of the file")


def _attributes(one: netCDF4.Dataset, other: netCDF4.Dataset, of: str) -> Iterator[str]:
    old, new = ({name: each.getncattr(name) for name in each.ncattrs()} for each in (one, other))
    for name in sorted((old.keys() | new.keys()) - {*_FREE}):
        if name not in old or name not in new or not np.array_equal(old[name], new[name]):
            yield f"{name} {of} is {old.get(name)} there, {new.get(name)} here"


if __name__ == "__main__":
    sys.exit(main())
