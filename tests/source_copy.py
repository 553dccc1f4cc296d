"""An editable copy of both packages, and commands that it runs: the behavior of another program version."""

import json
import shutil

from processes import CHECKOUT, python

_SESSION = """
import contextlib, io, json, shlex, sys
from sweep.cli import main

ends = {}
for line in json.loads(sys.argv[1]):
    out, err, sys.argv = io.StringIO(), io.StringIO(), ["eulerdisk", *shlex.split(line)]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except BaseException as end:
            status = end.code if isinstance(end, SystemExit) else repr(end)
    ends[line] = [status, out.getvalue(), err.getvalue()]
print(json.dumps(ends))
"""


class SourceCopy:
    """A copy of `kernels` and `sweep` in a folder."""

    def __init__(self, folder):
        self.folder = folder
        for package in ("kernels", "sweep"):
            shutil.copytree(
                CHECKOUT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__")
            )

    def edit(self, file, before, after):
        """Replace a text that appears once in a file."""
        path = self.folder / file
        source = path.read_text()
        assert source.count(before) == 1, (file, before)
        path.write_text(source.replace(before, after))

    def command(self, words, folder):
        """Run a command line of the copy in a folder and return its result."""
        return self.python("-m", "sweep", *words.split(), folder=folder)

    def session(self, lines, folder):
        """Run command lines of the copy in one process; return line -> status, output, messages."""
        done = self.python("-c", _SESSION, json.dumps(lines), folder=folder)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def python(self, *words, folder):
        """Run Python on the copy in a folder and return its result."""
        return python(*words, folder=folder, packages=self.folder)
