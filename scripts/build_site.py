"""Build the documentation: every page of docs/ as HTML, without warnings.

python scripts/build_site.py [FOLDER]    site-out/ in the project's folder if no other is named

Needs the dependency group `docs` of pyproject.toml. Exit status 1 if there is any warning: a broken link, an unknown
name in a docstring, a formula that cannot be converted, a page in no table of contents.
"""

import sys
import tempfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]


def main(arguments: list[str]) -> int:
    """Build into the named folder; return the exit status."""
    if len(arguments) > 1 or any(each.startswith("-") for each in arguments):
        print(__doc__)
        return 0 if arguments[0] in ("-h", "--help") else 2
    try:
        from sphinx.cmd.build import build_main
    except ImportError:
        print(
            "Sphinx is not installed: pip install --group docs (pip 25.1 or newer), or run scripts/site.",
            file=sys.stderr,
        )
        return 2
    # The checkout comes first: other packages also install modules named `sweep` and `kernels`.
    sys.path[:0] = [str(CHECKOUT), str(CHECKOUT / "docs" / "_site")]
    out = Path(*arguments).resolve() if arguments else CHECKOUT / "site-out"
    # Sphinx's cache, not kept, because every build is a complete one
    with tempfile.TemporaryDirectory() as doctrees:
        strict = ["-n", "-W", "--keep-going", "-q", "-E", "-a"]
        status = build_main(
            ["-b", "html", *strict, "-c", str(CHECKOUT / "docs"), "-d", doctrees, str(CHECKOUT), str(out)]
        )
    if status == 0:
        print(out / "index.html")
    return int(status != 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
