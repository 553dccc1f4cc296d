"""Print the share of each room that the tests reached, the lowest first: the end of `scripts/test --coverage`."""

import json
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

CHECKOUT = Path(__file__).parents[1]


def rooms(report: dict[str, dict[str, dict[str, int]]]) -> dict[str, tuple[int, int]]:
    """Return the reached statements of each room, and all of its statements, from a coverage report in JSON."""
    found: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for name, file in report.items():
        room = found["/".join(Path(name).parts[:2]).removesuffix(".py")]
        room[0] += file["summary"]["covered_lines"]
        room[1] += file["summary"]["num_statements"]
    return {name: (reached, size) for name, (reached, size) in found.items() if size}


if __name__ == "__main__":
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        words = [sys.executable, "-m", "coverage", "json", "-q", "-o", file.name]
        subprocess.run(words, cwd=CHECKOUT, check=True)
        by_room = rooms(json.load(file)["files"])
    for name, (reached, size) in sorted(by_room.items(), key=lambda row: row[1][0] / row[1][1]):
        print(f"{name:<28} {100 * reached / size:5.1f} % of {size} statements")
