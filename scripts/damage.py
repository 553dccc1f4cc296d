"""Damaged, edited and foreign files, made from intact atlases by a seeded generator, for `scripts/fuzz`.

Each way is a function in `BYTES`, `EDITS` or `foreign_files.FOREIGN`; add a function for a new way.
"""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from foreign_files import FOREIGN
from odd_words import TEXTS

#: Function that changes an open file of an atlas.
Edit = Callable[[Any, random.Random], None]

#: JSON that is not the spec of an atlas, or the spec of an absurd atlas.
SPECS: tuple[Callable[[dict[str, Any]], str], ...] = (
    lambda spec: "[" * 100_000,
    lambda spec: '{"a":' * 50_000 + "1" + "}" * 50_000,
    lambda spec: json.dumps(spec | {"tilt": json.loads("[" * 400 + "]" * 400)}),
    lambda spec: json.dumps(spec)[:-1],
    lambda spec: json.dumps(list(spec)),
    lambda spec: "null",
    lambda spec: "{}",
    lambda spec: "1" * 10_000,
    lambda spec: json.dumps(spec | {"self": 1}),
    lambda spec: json.dumps(spec | {"axes": []}),
    lambda spec: json.dumps(spec | {"axes": [["tilt"], "roll_rate"]}),
    lambda spec: json.dumps(spec | {"axes": spec["axes"][::-1]}),
    lambda spec: json.dumps(spec | {"axes": "x" * 2**20}),
    lambda spec: json.dumps(spec | {"model": "x" * 2**20}),
    lambda spec: json.dumps(spec | {"model": ["disk"]}),
    lambda spec: json.dumps(spec | {"model": "os:system"}),
    lambda spec: json.dumps(spec | {"criterion": {"kind": [], "limit": 1}}),
    lambda spec: json.dumps(spec | {"criterion": {"kind": "departure", "limit": None}}),
    lambda spec: json.dumps(spec | {"criterion": {"kind": "departure", "limit": 1, "more": 2}}),
    lambda spec: json.dumps(spec | {"criterion": "amplification:1e-300"}),
    lambda spec: json.dumps(spec | {"method": "exact"}),
    lambda spec: json.dumps(spec | {"method": 5}),
    lambda spec: json.dumps(spec | {"contact": "no" if spec.get("contact") == "yes" else "yes"}),
    lambda spec: json.dumps(spec | {"boundary": "refined:1e-300"}),
    lambda spec: json.dumps(spec | {"boundary": "refined:\uff11"}),
    lambda spec: json.dumps(spec | {"boundary": "refined:1e-6"}),
    lambda spec: json.dumps(spec | {"device": "cuda"}),
    lambda spec: json.dumps(spec | {"tolerance": 1e-300}),
    lambda spec: json.dumps(spec | {"duration": 1e300}),
    lambda spec: json.dumps(spec | {"radius": float("nan")}),
    lambda spec: json.dumps(spec | {"radius": 1e-300, "gravity": 1e300}),
    lambda spec: json.dumps(spec | {"alpha": True}),
    lambda spec: json.dumps(spec | {"alpha": "1 kg/kg*(9**9**9)"}),
    lambda spec: json.dumps(spec | {"radius": "9**9**9 m"}),
    lambda spec: json.dumps(_with_count(spec, 10**400)),
    lambda spec: json.dumps(_with_count(spec, 2**62)),
    lambda spec: json.dumps(_with_count(spec, 2**33)),
    lambda spec: json.dumps(_with_count(spec, -1)),
    lambda spec: json.dumps(_with_count(spec, 7.0)),
    lambda spec: json.dumps(_with_count(spec, 7)),
    *(lambda spec, text=text: json.dumps(spec | {"title": text}) for text in TEXTS),
)


def _with_count(spec: dict[str, Any], count: float) -> dict[str, Any]:
    name = spec["axes"][0]
    held = spec[name] if "count" in spec[name] else {"start": 1.0, "stop": 2.0, "spacing": "linear"}
    return spec | {name: held | {"count": count}}


def _flip_bit(content: bytearray, dice: random.Random) -> bytearray:
    content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    return content


def _flip_early(content: bytearray, dice: random.Random) -> bytearray:
    for _ in range(dice.choice((1, 1, 4))):
        content[dice.randrange(min(len(content), 4096))] = dice.randrange(256)
    return content


def _flip_many(content: bytearray, dice: random.Random) -> bytearray:
    for _ in range(dice.choice((3, 30, 300))):
        content[dice.randrange(len(content))] = dice.randrange(256)
    return content


def _change_text(content: bytearray, dice: random.Random) -> bytearray:
    """Change a letter of a readable text: this reaches names, attributes and JSON instead of only numbers."""
    words = [b"units", b"flag_", b"tilt", b"ending", b"coordinates", b"_FillValue", b"DIMENSION", b"sweep_", b"curve",
             b"{", b"axes", b"boundary", b"stability", b"_nc3", b"CLASS", b"REFERENCE_LIST", b"OHDR", b"FRHP",
             b"BTHD", b"BTLF", b"FADB", b"FAHD", b"FHDB", b"OCHK", b"TREE", b"HEAP", b"SNOD"]  # fmt: skip
    places = [at for word in words for at in _places(content, word)]
    for _ in range(dice.choice((1, 2, 5))):
        at = dice.choice(places) + dice.randrange(24)
        content[at % len(content)] = dice.choice((0, 1, 255, 127, 32, dice.randrange(256)))
    return content


def _places(content: bytearray, word: bytes) -> list[int]:
    found, at = [], content.find(word)
    while at >= 0:
        found.append(at)
        at = content.find(word, at + 1)
    return found


def _zero(content: bytearray, dice: random.Random) -> bytearray:
    start, count = dice.randrange(len(content)), dice.choice((4, 64, 512, 4096))
    content[start : start + count] = bytes(len(content[start : start + count]))
    return content


def _fill(content: bytearray, dice: random.Random) -> bytearray:
    start, count = dice.randrange(len(content)), dice.choice((2, 4, 8))
    content[start : start + count] = b"\xff" * len(content[start : start + count])
    return content


def _move(content: bytearray, dice: random.Random) -> bytearray:
    to, source = (dice.randrange(len(content) - 512) for _ in range(2))
    content[to : to + 512] = content[source : source + 512]
    return content


def _cut(content: bytearray, dice: random.Random) -> bytearray:
    return content[: dice.choice((dice.randrange(len(content)), len(content) - dice.randrange(1, 64)))]


def _insert(content: bytearray, dice: random.Random) -> bytearray:
    at = dice.randrange(len(content))
    return content[:at] + bytearray(dice.randbytes(dice.choice((1, 8, 512)))) + content[at:]


def _append(content: bytearray, dice: random.Random) -> bytearray:
    return content + bytearray(dice.randbytes(dice.choice((1, 4096))))


#: Damages of the bytes of a file.
BYTES = (_flip_bit, _flip_early, _flip_many, _change_text, _zero, _fill, _move, _cut, _insert, _append)


def _variables(file: Any) -> list[str]:
    return [name for name in file if isinstance(file[name], h5py.Dataset)]


def _delete_variable(file: Any, dice: random.Random) -> None:
    del file[dice.choice(_variables(file))]


def _rename_variable(file: Any, dice: random.Random) -> None:
    name = dice.choice(_variables(file))
    file.move(
        name, dice.choice((name.upper(), "x", name + "\x1b[31m", "ünï", "a b", *_variables(file))) + "_"
    )


def _swap_variables(file: Any, dice: random.Random) -> None:
    one, other = dice.sample(_variables(file), 2)
    file.move(one, "between")
    file.move(other, one)
    file.move("between", other)


def _delete_attribute(file: Any, dice: random.Random) -> None:
    at = _with_attributes(file, dice)
    del at[dice.choice(list(at))]


def _rename_attribute(file: Any, dice: random.Random) -> None:
    at = _with_attributes(file, dice)
    at.create("renamed", at[(name := dice.choice(list(at)))])
    del at[name]


def _with_attributes(file: Any, dice: random.Random) -> Any:
    places = [file.attrs, *(file[name].attrs for name in _variables(file))]
    return dice.choice([each for each in places if len(each)])


def _odd_values(dice: random.Random) -> list[Any]:
    return [
        0, -1, 2**62, float("nan"), float("inf"), np.zeros(3), np.zeros((2, 2)), np.array([], "f8"), True,
        np.bytes_(b"\xff\xfe\x80"), np.bytes_(dice.randbytes(20)), dice.choice(TEXTS).replace("\0", ""),
        h5py.Empty("f8"), h5py.Empty("S1"), np.array(["a", "b"], object), 1j, np.zeros(1, [("a", "i4")]),
        "seconds since 1970-01-01", "days", "furlongs", "status_flag", np.arange(5, dtype="i1"),
    ]  # fmt: skip


def _set(at: Any, name: str, value: Any) -> None:
    if isinstance(value, np.ndarray) and value.dtype == object:
        at.create(name, value, dtype=h5py.string_dtype())
    else:
        at.create(name, value)


def _odd_attribute(file: Any, dice: random.Random) -> None:
    at = _with_attributes(file, dice)
    _try_set(at, dice.choice(list(at)), dice)


def _odd_global(file: Any, dice: random.Random) -> None:
    names = [name for name in file.attrs if not name.startswith("_")]
    _try_set(file.attrs, dice.choice(names), dice)


def _new_attribute(file: Any, dice: random.Random) -> None:
    names = ("scale_factor", "add_offset", "missing_value", "_FillValue", "valid_range", "units", "calendar", "bounds",
             "grid_mapping", "_Unsigned", "dtype", "_Encoding", "coordinates", "cell_measures", "_Netcdf4Coordinates",
             "_Netcdf4Dimid", "_NCProperties", "_nc3_strict", "formula_terms", "flag_masks")  # fmt: skip
    _try_set(file[dice.choice(_variables(file))].attrs, dice.choice(names), dice)


def _try_set(at: Any, name: str, dice: random.Random) -> None:
    value = dice.choice(_odd_values(dice))
    # an attribute in an object header has at most 64 kB; h5py chooses the dense form for longer ones
    if isinstance(value, str) and len(value) > 60_000:
        value = value[:60_000]
    _set(at, name, value)


def _spec(file: Any, dice: random.Random) -> None:
    text = dice.choice(SPECS)(json.loads(file.attrs["sweep_spec"])).encode("ascii", "backslashreplace")
    file.attrs.create("sweep_spec", np.bytes_(text[:64_000] if len(text) > 64_000 else text))


def _spec_string(file: Any, dice: random.Random) -> None:
    """Write a long spec as a string of variable length, which has no limit."""
    text = dice.choice(SPECS)(json.loads(file.attrs["sweep_spec"]))
    file.attrs.create("sweep_spec", text.encode("utf-8", "replace").decode(), dtype=h5py.string_dtype())


def _title(file: Any, dice: random.Random) -> None:
    text = dice.choice(TEXTS).replace("\0", "")
    file.attrs.create(dice.choice(("title", "history", "source")), text, dtype=h5py.string_dtype())


def _values(file: Any, dice: random.Random) -> None:
    """Write numbers that no atlas contains."""
    held = file[dice.choice(_variables(file))]
    values = held[...]
    odd = dice.choice((np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, 1e-300, 99.0, 127.0))
    with np.errstate(all="ignore"):
        part = np.array(odd).astype(values.dtype)
    if dice.random() < 0.5 or not values.shape:
        held[...] = part
    else:
        held[tuple(dice.randrange(n) for n in values.shape)] = part


def _reversed_values(file: Any, dice: random.Random) -> None:
    held = file[dice.choice(_variables(file))]
    values = held[...]
    held[...] = np.flip(values) if values.shape else values


def _other_type(file: Any, dice: random.Random) -> None:
    name = dice.choice(_variables(file))
    kind = dice.choice(
        ("i8", "u1", "f4", "i4", "f8", "S4", "S1", ">f8", "c16", "text", "enum", "compound", "b1")
    )
    values = file[name][...]
    with np.errstate(all="ignore"):
        if kind == "text":
            made = values.astype(str).astype(object)
            _replace(file, name, made, dtype=h5py.string_dtype())
        elif kind == "enum":
            _replace(file, name, values.astype("i1"), dtype=h5py.enum_dtype({"a": 0, "b": 1}, "i1"))
        elif kind == "compound":
            _replace(file, name, np.zeros(values.shape, [("a", "i4"), ("b", "f8")]))
        else:
            _replace(file, name, values.astype(kind))


def _other_shape(file: Any, dice: random.Random) -> None:
    name = dice.choice(_variables(file))
    values = file[name][...]
    shapes = (values.T, values[None], values.reshape(-1), values.reshape(-1)[:1], values.reshape(-1)[:0],
              np.resize(values, (3, 3, 3)), values.reshape(-1)[0])  # fmt: skip
    _replace(file, name, np.array(dice.choice(shapes)))


def _huge(file: Any, dice: random.Random) -> None:
    """Give a variable many more values than the file has bytes."""
    name = dice.choice(_variables(file))
    rank = max(1, file[name].ndim)
    count = dice.choice((10**5, 2**28, 2**31, 2**33, 2**40))
    shape = (count, *[1] * (rank - 1))
    _replace(
        file, name, None, shape=shape, chunks=(min(count, 2**16), *[1] * (rank - 1)), dtype=file[name].dtype
    )


def _huge_grid(file: Any, dice: random.Random) -> None:
    """Give an axis a count, in the spec and in all variables, that exceeds the bytes of the file."""
    spec = json.loads(file.attrs["sweep_spec"])
    axis, count = spec["axes"][-1], dice.choice((10**6, 10**8, 2**33))
    values = file[axis][...]
    spec[axis] = {"start": float(values[0]), "stop": float(values[-1]), "count": count, "spacing": "linear"}
    file.attrs["sweep_spec"] = np.bytes_(json.dumps(spec).encode())
    old = values.size
    for name in _variables(file):
        held = file[name]
        if old in held.shape:
            shape = tuple(count if n == old else n for n in held.shape)
            chunks = tuple(min(n, 2**14) for n in shape)
            _replace(file, name, None, shape=shape, chunks=chunks, dtype=held.dtype, attach=False)
    made = file[axis]
    made.make_scale(axis)
    for name in _variables(file):
        for place, n in enumerate(file[name].shape):
            if n == count and name != axis:
                file[name].dims[place].attach_scale(made)


def _replace(file: Any, name: str, values: Any, *, attach: bool = True, **how: Any) -> None:
    old = file[name]
    kept = {key: old.attrs[key] for key in old.attrs if key.isidentifier() and not key.isupper()}
    kept.pop("_FillValue", None)
    del file[name]
    made = file.create_dataset(name, data=values, **how)
    for key, value in kept.items():
        _set(made.attrs, key, value)
    if not attach:
        return
    for place, n in enumerate(made.shape):
        for other in _variables(file):
            if other != name and file[other].ndim == 1 and file[other].shape[0] == n and file[other].is_scale:
                made.dims[place].attach_scale(file[other])
                break


def _links(file: Any, dice: random.Random) -> None:
    """Create links: to nothing, to itself, to a file outside, to the root group."""
    name = dice.choice(_variables(file))
    del file[name]
    file[name] = dice.choice(
        (
            h5py.SoftLink("/nothing"),
            h5py.SoftLink(f"/{name}"),
            h5py.ExternalLink("/etc/passwd", "/"),
            h5py.SoftLink("/"),
        )
    )


def _groups(file: Any, dice: random.Random) -> None:
    group = file
    for _ in range(dice.choice((1, 3, 200))):
        group = group.create_group("g")
    group["x"] = np.zeros(3)


def _many(file: Any, dice: random.Random) -> None:
    for number in range(dice.choice((10, 300))):
        file.create_dataset(f"v{number}", data=dice.random())


def _same_dimension(file: Any, dice: random.Random) -> None:
    name = dice.choice([each for each in _variables(file) if file[each].is_scale and file[each].ndim == 1])
    made = file.create_dataset("square", data=np.zeros((file[name].size,) * 2))
    for place in (0, 1):
        made.dims[place].attach_scale(file[name])


def _no_such_filter(file: Any, dice: random.Random) -> None:
    """Compress a variable with a filter that is not installed."""
    name = dice.choice(_variables(file))
    values = file[name][...]
    if values.shape:
        _replace(file, name, values, compression="lzf", chunks=values.shape)


def _external_values(file: Any, dice: random.Random) -> None:
    """Store the values of a variable in another file, which any process could read."""
    name = dice.choice([each for each in _variables(file) if file[each].ndim])
    held = file[name]
    size = held.size * held.dtype.itemsize
    _replace(file, name, None, shape=held.shape, dtype=held.dtype, external=[("/etc/passwd", 0, size)])


#: Edits of the structure of an atlas.
EDITS = (
    _delete_variable, _rename_variable, _swap_variables, _delete_attribute, _rename_attribute, _odd_attribute,
    _odd_global,
    _new_attribute, _spec, _spec_string, _title, _values, _reversed_values, _other_type, _other_shape, _huge,
    _huge_grid,
    _links, _groups, _many, _same_dimension, _no_such_filter, _external_values,
)  # fmt: skip


def damage_file(path: Path, wholes: list[Path], dice: random.Random) -> str:
    """Write one damaged, edited or foreign file; return a description of it.

    Parameters
    ----------
    path : Path
        The file, which does not exist yet.
    wholes : list of Path
        Atlases.
    dice : random.Random
    """
    kind, whole = dice.random(), dice.choice(wholes)
    if kind < 0.4:
        way = dice.choice(BYTES)
        path.write_bytes(way(bytearray(whole.read_bytes()), dice))
        return f"{way.__name__.lstrip('_')} of {whole.name}"
    if kind < 0.9:
        path.write_bytes(whole.read_bytes())
        ways: list[Edit] = [dice.choice(EDITS) for _ in range(dice.choice((1, 1, 1, 2)))]
        edit(path, ways, dice)
        return f"{', '.join(way.__name__.lstrip('_') for way in ways)} of {whole.name}"
    foreign = dice.choice(FOREIGN)
    foreign(path, dice)
    return f"foreign: {foreign.__name__.lstrip('_')}"


def edit(path: Path, ways: list[Edit], dice: random.Random) -> None:
    """Edit the structure of an atlas, skipping impossible edits."""
    with h5py.File(path, "r+") as file:
        for way in ways:
            try:
                way(file, dice)
            except (ValueError, TypeError, KeyError, OSError, RuntimeError, IndexError):
                # an earlier edit may have removed what this one needs
                continue
