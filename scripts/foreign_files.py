"""Files of other tools, and objects that are not files, for the fuzzer; add a function to `FOREIGN` for a new one."""

import os
import random
import socket
import sqlite3
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import netCDF4
import numpy as np
from odd_words import TEXTS


def _bytes_file(content: bytes) -> Callable[[Path, random.Random], None]:
    def write(path: Path, dice: random.Random) -> None:
        path.write_bytes(content)

    return write


def _noise(path: Path, dice: random.Random) -> None:
    path.write_bytes(dice.randbytes(dice.choice((1, 100, 10_000))))


def _hdf5_noise(path: Path, dice: random.Random) -> None:
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + dice.randbytes(dice.choice((0, 10, 100, 10_000))))


def _classic_noise(path: Path, dice: random.Random) -> None:
    path.write_bytes(
        b"CDF" + bytes([dice.choice((1, 2, 5))]) + dice.randbytes(dice.choice((0, 8, 100, 10_000)))
    )


def _classic_absurd(path: Path, dice: random.Random) -> None:
    """Write a netCDF-3 header with counts of 2**31 dimensions, attributes or characters."""
    most = (2**31 - 1).to_bytes(4, "big")
    part = dice.choice((b"\0\0\0\x0a" + most, b"\0" * 8 + b"\0\0\0\x0c" + most, b"\0\0\0\x0a\0\0\0\1" + most))
    path.write_bytes(b"CDF\x01\0\0\0\0" + part + b"abcd" * 8)


def _other_netcdf(path: Path, dice: random.Random) -> None:
    kind: Any = dice.choice(
        ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4", "NETCDF4_CLASSIC")
    )
    with netCDF4.Dataset(path, "w", format=kind) as file:
        file.title = dice.choice(TEXTS[:4])
        file.createDimension("time", None)
        file.createDimension("lat", 3)
        time = file.createVariable("time", "f8", ("time",))
        time.units = dice.choice(("days since 1970-01-01", "months since 0000-00-00", "banana since 1"))
        file.createVariable("sst", "i2", ("time", "lat")).scale_factor = 0.01
        time[:] = [1e300, 2.0]


def _claims_to_be_one(path: Path, dice: random.Random) -> None:
    """Write a netCDF file that has the attributes of an atlas, but nothing else of one."""
    with netCDF4.Dataset(path, "w", format=dice.choice(("NETCDF3_CLASSIC", "NETCDF4"))) as file:
        file.eulerdisk_format = np.int32(1)
        file.sweep_spec = dice.choice(("{}", "[]", '{"axes": []}', "x" * 1000))


def _hdf5(path: Path, dice: random.Random) -> None:
    with h5py.File(path, "w") as file:
        file["a/b/c"] = np.arange(5)
        file.attrs["sweep_spec"] = "{}"


def _zip(path: Path, dice: random.Random) -> None:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a", "b")


def _database(path: Path, dice: random.Random) -> None:
    connection = sqlite3.connect(path)
    connection.execute("create table a (b)")
    connection.commit()
    connection.close()


def _folder(path: Path, dice: random.Random) -> None:
    path.mkdir()


def _pipe(path: Path, dice: random.Random) -> None:
    os.mkfifo(path)


def _device(path: Path, dice: random.Random) -> None:
    path.symlink_to(
        dice.choice(("/dev/zero", "/dev/null", "/dev/full", "/proc/self/mem", "/proc/self/environ"))
    )


def _loop(path: Path, dice: random.Random) -> None:
    path.symlink_to(path.name)


def _socket(path: Path, dice: random.Random) -> None:
    before = os.getcwd()
    os.chdir(path.parent)
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
    finally:
        os.chdir(before)


def _sparse(path: Path, dice: random.Random) -> None:
    with open(path, "wb") as file:
        file.write(dice.choice((b"", b"\x89HDF\r\n\x1a\n", b"CDF\x01")))
        file.truncate(2**36)


#: Files of other tools, and objects that are not files.
FOREIGN = (
    _bytes_file(b""), _bytes_file(b"a,b\n1,2\n"), _bytes_file(b"\x89PNG\r\n\x1a\n" + bytes(50)),
    _bytes_file(b"SIMPLE  =                    T" + b" " * 2850), _bytes_file(b"PAR1" + bytes(20) + b"PAR1"),
    _bytes_file(b"\x1f\x8b\x08" + bytes(20)), _bytes_file(b"\x0e\x03\x13\x01" + bytes(60)),
    _bytes_file(b"GRIB" + bytes(60)),
    _noise, _hdf5_noise, _classic_noise, _classic_absurd, _other_netcdf, _claims_to_be_one, _hdf5, _zip, _database,
    _folder, _pipe, _device, _loop, _socket, _sparse,
)  # fmt: skip
