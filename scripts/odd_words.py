"""Odd texts, and requests from a seeded generator: words of the command line, and spec files; for `scripts/fuzz`."""

import os
import random
from collections.abc import Callable
from pathlib import Path

#: Texts that break careless programs: mathematics, markup, control sequences, other scripts, length.
TEXTS = (
    "",
    "$",
    r"$\frac{\frac{\frac{1}{2}}{3}}{$",
    "{" * 5000,
    r"\x" + "$" * 1001,
    "[red]rich[/red] [link=http://x]y[/]",
    "\x1b[31mred\x1b]0;title\x07\x9b2J",
    "line\nline\r\nline\ttab\x00nul\x7f",
    "滚动的圆盘 جسم 😀 \u202egnp.exe",
    "%s %n {0} {}",
    "x" * 2**20,
    "../../../etc/passwd",
    "nan",
    "1e999",
    "\ud7ff\uffff\u2028",
)

_NAMES = ("tilt", "tilt_rate", "roll_rate", "precession_rate", "alpha", "radius", "gravity", "criterion", "duration",
          "step", "tolerance", "fall_tilt", "method", "contact", "boundary", "device", "title", "axes", "samples",
          "seed", "start", "starts", "model",
          "self",
          "speed", "scaled_roll_rate", "scaled_tilt_rate", "words", "", "tilt\x1b[31m", "x" * 10_000)  # fmt: skip

_VALUES = (
    "1", "-1", "0", "1e400", "1e-400", "nan", "inf", "-inf", "\uff11", "1_000", "0x10", "1j", "1e", "--1",
    "\u22121deg",
    "1 m*(9**9**9)", "1 m**9**9**9", "1 m^999999999", "1 (m)", "1 ((((((m))))))", "1 m" + "*m" * 500,
    "1 " + "m" * 10**5,
    "1 " + "(" * 5000, "1 m[0]", "1 __import__('os')", "1 lambda:0", "1 [length]", "1 degC", "1 delta_degC", "1 dB",
    "1 km**99", "1 m/0", "1 %", "1 m//2", "1 m%2", "1 'm'", "1 \x00", "1 \u00b5m", "1 m\u00b2/m", "1 \u2126",
    "1 m e9",
    "1 meter per second", "1deg:2deg", "1deg:2deg:3", "1deg:2deg:0", "1deg:2deg:-3", "1deg:2deg:\uff13", "1:2:3:4:5",
    "1deg:2deg:3:LOG", "1deg:2deg:10000000", "2:4:1000000000", "1e-300:1e300:999999:log",
    "1deg:2deg:999999999999999999",
    ",", ",,", "1,2,", ",".join(map(str, range(1, 30_000))), "1" * 10**6, "1." + "0" * 10**6, "steady", "steady-slow",
    "uniform:1deg:2deg", "uniform:2:", "normal:nan:1", "loguniform:1e-320:1", "normal:1:1e308", "uniform:\uff11:2",
    "/dev/zero", "rolling.nc",
    "departure:5deg", "departure:", "departure:1e9deg", "amplification:" + "9" * 500, "refined:1e-300", "refined:nan",
    "refined:\uff11e-6", "refined:1_0", "peak_tilt>1deg", "peak_tilt>", "peak_tilt > 1", "fall_time < 2 m*(9**9**9)",
    "not " * 300, "(" * 10**5 + ">", "tilt>0or " * 10**5, "peak_tilt >= 1e400", "ending == fell", "ending==\x1b[31m",
    "__import__('os')>1", "peak_tilt > 1" + "0" * 900, "tilt" + "<1deg" * 190, "wells==two_wells",
    "cuda", "exact", "yes", "auto", *TEXTS[:10], *TEXTS[11:],
)  # fmt: skip

_LINES = (
    "eulerdisk", "--help", "plan rolling --threads \uff12", "plan rolling --block-cells 1_000",
    "block --run nowhere --part \uff11/\uff13",
    "block --run rolling.nc --part 1/1", "assemble rolling.nc", "assemble .", "assemble /", "info /", "info .",
    "info \x1b[31m.nc",
    "info " + "x" * 5000, "explain rolling.nc tilt=\uff11deg roll_rate=2", "explain rolling.nc tilt=nan roll_rate=2",
    "explain rolling.nc tilt=1e300 roll_rate=2", "explain random.nc start=1e300",
    "explain random.nc start=0.5", "plan rolling samples=2e9 seed=1 tilt=1deg roll_rate=uniform:2:4",
    "boundary rolling.nc --refine nan",
    "boundary rolling.nc --refine 1e-300",
    "boundary rolling.nc --refine -1", "plot rolling.nc --friction nan -o OUT/a.png",
    "plot rolling.nc --friction 1e999 -o OUT/a.png",
    "boundary rolling.nc --criterion [red]", "export rolling.nc --to \x1b[31m", "compare rolling.nc rolling.nc",
    "run rolling --from rolling.nc -o OUT/a.nc", "plan nothing", "plan /dev/zero", "plan rolling.nc", "plan .toml",
    "plan OUT",
    "simulate --from rolling.nc roll_rate=\uff12 tilt=1deg -o OUT/path.nc --overwrite",
    "simulate --from rolling.nc speed=1e300 tilt=1deg -o OUT/path.nc --overwrite", "simulate --from / -o OUT/a.nc",
    "simulate tilt=1deg title=$ -o OUT/path.nc --overwrite --plot OUT/path.png",
)  # fmt: skip


def words(dice: random.Random) -> list[str]:
    """Return the words of one odd request."""
    if dice.random() < 0.2:
        return [word.replace("\0", "") for word in dice.choice(_LINES).split(" ")]
    changes = [f"{dice.choice(_NAMES)}={dice.choice(_VALUES)}" for _ in range(dice.choice((1, 1, 2, 3)))]
    if dice.random() < 0.2:
        changes.append(dice.choice(_VALUES))
    # the system passes neither NUL nor surrogates in an argument
    fit = [word.replace("\0", "").encode("utf-8", "replace").decode() for word in changes]
    kind = dice.choice(
        ("plan rolling --no-calibrate", "plan spinning", "simulate -o OUT/path.nc --overwrite")
    )
    return [*kind.split(), "--", *fit]


def spec_file(path: Path, dice: random.Random) -> str:
    """Write one odd spec file, and return a description of it."""
    name, write = dice.choice(FILES)
    write(path, dice)
    return name


def _text(make: Callable[[random.Random], str | bytes]) -> Callable[[Path, random.Random], None]:
    def write(path: Path, dice: random.Random) -> None:
        made = make(dice)
        path.write_bytes(made.encode("utf-8", "replace") if isinstance(made, str) else made)

    return write


def _odd_value(dice: random.Random) -> str:
    return dice.choice(
        ("1", "[]", "[[1]]", "[1, 'a']", "{a = 1}", "true", "1979-05-27", "07:32:00", "0x1f", "1e400", "nan", "-inf",
         "9" * 5000, "[1.0, 1.0]", "[" * 300 + "]" * 300, "'''\n'''", '"\\u0000"', '"1 m*(9**9**9)"', '"$"',
         '"2:4:9"',
         '"2:4:1000000000"', "[" + "1e9," * 10_000 + "]")
    )  # fmt: skip


def _mutate(dice: random.Random) -> bytes:
    content = bytearray(
        b'roll_rate = "2:4:9"\ntilt = "1deg:5deg:4:log"\ncriterion = "departure:5deg"\ntitle = "a"\n'
    )
    for _ in range(dice.choice((1, 2, 8))):
        content[dice.randrange(len(content))] = dice.randrange(256)
    return bytes(content)


def _sparse(path: Path, dice: random.Random) -> None:
    with open(path, "wb") as file:
        file.truncate(2**36)


_DEVICES = ("/dev/zero", "/dev/full", "/dev/null", "/proc/self/mem")

#: Kinds of spec files: their names, and the function that writes one.
FILES: tuple[tuple[str, Callable[[Path, random.Random], None]], ...] = (
    ("odd value", _text(lambda dice: f"{dice.choice(_NAMES[:24])} = {_odd_value(dice)}\n")),
    ("odd value", _text(lambda dice: f"{dice.choice(_NAMES[:22])} = {_odd_value(dice)}\n")),
    ("odd title", _text(lambda dice: f'title = """{dice.choice(TEXTS)}"""\n')),
    ("changed bytes", _text(_mutate)),
    ("changed bytes", _text(_mutate)),
    ("noise", _text(lambda dice: dice.randbytes(dice.choice((1, 100, 10_000))))),
    ("nested arrays", _text(lambda dice: "a = " + "[" * dice.choice((900, 5000, 10**5)))),
    ("nested tables", _text(lambda dice: "a = " + "{b = " * dice.choice((300, 5000)))),
    ("dotted key", _text(lambda dice: ".".join("a" * dice.choice((100, 20_000))) + " = 1")),
    ("many keys", _text(lambda dice: "\n".join(f"k{i} = 1" for i in range(20_000)))),
    ("long line", _text(lambda dice: 'title = "' + "x" * 10**6 + '"')),
    ("long list", _text(lambda dice: "tilt = [" + ", ".join(f"{i}e-6" for i in range(60_000)) + "]")),
    ("many tables", _text(lambda dice: "[[a]]\n" * 30_000)),
    ("sections", _text(lambda dice: f"[{dice.choice(_NAMES[:6])}]\nstart = 1\n")),
    ("not UTF-8", _text(lambda dice: b"title = '\xff\xfe'")),
    ("UTF-16", _text(lambda dice: "title = 'a'".encode("utf-16"))),
    ("no end", _text(lambda dice: 'title = """' + "\\" * dice.choice((1, 10**5)))),
    ("pipe", lambda path, dice: os.mkfifo(path)),
    ("folder", lambda path, dice: path.mkdir()),
    ("device", lambda path, dice: path.symlink_to(dice.choice(_DEVICES))),
    ("loop", lambda path, dice: path.symlink_to(path.name)),
    ("sparse", _sparse),
    ("64 MB", _text(lambda dice: b"# \n" * (2**26 // 3))),
)  # fmt: skip
