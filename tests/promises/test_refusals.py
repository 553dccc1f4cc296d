"""Refusals of every command: `refusals.txt` lists command lines with the facts that each must state."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from messages import missing

from sweep import cli

HERE = Path(__file__).parent


def listed():
    """Return command line, exit status, mark and facts of each refusal in the list."""
    text = (HERE / "refusals.txt").read_text(encoding="utf-8")
    entries = re.findall(r"^\$ (.*)\n\[(\d+) ?(\w*)\] (.*)$", text, re.MULTILINE)
    assert len(entries) == text.count("\n$ ")
    return [(line, int(status), mark, facts.split("; ")) for line, status, mark, facts in entries]


def faults(line, status, mark, facts, out, err):
    """Return the defects of a command's refusal."""
    lines = err.splitlines()
    if mark == "typer":
        # Earlier lines show the available arguments and options.
        lines = lines[-1:]
    start = "Error: " if mark == "typer" else "eulerdisk: "
    found = [f"lacks {fact}" for fact in missing("\n".join(lines), facts)]
    if len(lines) != 1 + (mark == "noted") or not all(each.startswith(start) for each in lines):
        found.append(f"is not one line that begins with {start}")
    if out or "Traceback" in err:
        found.append("has more than the message")
    return [f"{line} [{status}] {fault}: {err}" for fault in found]


@pytest.mark.slow_lane
def test_refusals(tmp_path, monkeypatch, capsys):
    """Each listed command line ends with its status and one line with the facts, and writes nothing."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(HERE / "data" / "rolling.nc", "rolling.nc")
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    found = []
    for line, status, mark, facts in listed():
        monkeypatch.setattr("sys.argv", ["eulerdisk", *shlex.split(line)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert end.value.code == status, line
        found += faults(line, status, mark, facts, *capsys.readouterr())
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before, f"{line} wrote a file"
    assert not found, "\n".join(found)


#: A word with a value, as a hint gives it.
WORD = re.compile(r"\b([a-z]\w*)=[^\s;]*[^\s;,.?)]")


def followed(words, message):
    """Return a command's words after following a refusal's advice, or None if it names no word with a value.

    A typo is corrected in place; a word replaces the one of its name, or is added.
    """
    advice = re.split(r"(?<=[^.])\. (?=[A-Z])", message)[-1]
    if meant := re.fullmatch(r"Did you mean (\S+)\?", advice):
        slips = re.findall(r"(?:^|[:.] |: At character \d+: )(\S+?)(?:: | is no | is not )", message)
        changed = [[re.sub(rf"\b{re.escape(slip)}\b", meant[1], word) for word in words] for slip in slips]
        return next((each for each in reversed(changed) if each != words), None)
    if word := WORD.search(advice):
        gone = {word[1], message.split(": ")[1]} if "leave it out and" in advice else {word[1]}
        others = [each for each in words[2:] if each.partition("=")[0] not in gone]
        return [*words[:2], word[0], *others]
    return None


@pytest.mark.slow_lane
def test_advice_leads_on(tmp_path, monkeypatch, capsys):
    """Following the advice of successive refusals never leads to the same refusal again."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    accepted = steps = 0
    for line, _, mark, _ in listed():
        if mark or not re.match(r"(plan|run) [^-]+( -o \S+)?$", line):
            continue
        words = ["plan", *shlex.split(line.partition(" -o ")[0])[1:]]
        met = set()
        while words:
            monkeypatch.setattr("sys.argv", ["eulerdisk", *words, "--no-calibrate"])
            with pytest.raises(SystemExit) as end:
                cli.main()
            message = capsys.readouterr().err.strip()
            if not end.value.code:
                accepted += 1
                break
            assert message not in met, (line, words)
            met.add(message)
            words = followed(words, message)
            steps += words is not None
    assert accepted > 20
    assert steps > 30


#: Files that the command lines name.
FILES = {
    "two.toml": '[[sweep]]\nname = "a"\nspec = "rolling"\n[[sweep]]\nname = "b"\nspec = "spinning"\n',
    "typo.toml": 'roll_rate = "2:4:9"\ntlt = "1deg"\n',
    "unit.toml": 'roll_rate = "2:4:9"\ntilt = "1kg"\n',
    "broken.toml": "roll_rate = [1, 2\n",
    "starts.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2,-4\n3,x\n",
    "short.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2\n",
    "twice.csv": "tilt,tilt\n1,2\n",
    "lens.py": '@body(duration="10 s", stable="peak_tilt < 60deg")\ndef lens(tilt, *, q=0.5):\n'
    "    return sqrt(cos(tilt)**2 + q**2*sin(tilt)**2), 0.4, (1 + q**2)/5\n",
    "text.nc": "not a netCDF file\n",
}
