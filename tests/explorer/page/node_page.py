"""The page's modules without a browser: Node runs them, and Python asks for their results.

A `NodePage` evaluates functions like a page of Playwright:

    def test_unit_in_the_last_place(node):
        script = "async value => { const { ulp } = await import('eulerdisk/axis_window'); return ulp(value) }"
        assert node.evaluate(script, 1.0) == math.ulp(1.0)

There is no document; modules that need one are tested in tests/explorer/browser.
"""

import functools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

_FOLDER = Path(__file__).parent


class NodePage:
    """Node with the page's modules, until it is closed."""

    def __init__(self, url: str) -> None:
        node = find_node()
        if node is None:
            message = "no Node.js 22.15 or newer (scripts/test installs it)"
            pytest.fail(message) if os.environ.get("CI") == "true" else pytest.skip(message)
        self._process = subprocess.Popen(
            [node, "--import", f"{_FOLDER}/resolve.mjs", f"{_FOLDER}/evaluate.mjs", url],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )

    def evaluate(self, script: str, argument: object = None) -> object:
        """Return the result of a function of one argument, which may be a promise.

        Raises
        ------
        RuntimeError
            If the function throws.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        # an expression instead of JSON, because it may contain NaN and infinity
        self._process.stdin.write(json.dumps(f"({script})({json.dumps(argument)})") + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"Node ended with status {self._process.wait(timeout=30)}.")
        answer = json.loads(line)
        if "problem" in answer:
            raise RuntimeError(answer["problem"])
        return answer.get("found")

    def close(self) -> None:
        """End Node by closing its input."""
        with self._process:
            assert self._process.stdin is not None
            self._process.stdin.close()


@functools.cache
def find_node() -> str | None:
    """Return the path of Node, preferably the environment's, or None if it is missing or too old."""
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    found = shutil.which("node", path=places)
    is_new = "process.exit(require('node:module').registerHooks ? 0 : 1)"
    return found if found and subprocess.run([found, "-e", is_new], check=False).returncode == 0 else None
