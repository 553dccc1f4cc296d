"""The pytest plugin `eulerdisk_atlas`: a spec is run and compared with a reference file, or the file is renewed.

::

    def test_rolling(eulerdisk_atlas):
        eulerdisk_atlas("rolling roll_rate=2:4:20 tilt=0.1deg:20deg:10:log", "data/rolling.nc")

``pytest --eulerdisk-regen`` writes the reference files anew instead.
"""

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

_OPTION = "--eulerdisk-regen"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that renews the reference files."""
    group = parser.getgroup("eulerdisk")
    group.addoption(_OPTION, action="store_true", help="write the reference atlases of eulerdisk_atlas anew")


@pytest.fixture
def eulerdisk_atlas(request: pytest.FixtureRequest) -> Callable[[str, str | Path], None]:
    """Return a function that runs a spec and compares the atlas with a reference file.

    It takes the words of ``eulerdisk run``, as one text, and the path of the file, from the test's own folder. It
    fails the test with the report of ``eulerdisk compare`` if the two differ.
    """
    folder = request.path.parent

    def check(words: str, reference: str | Path) -> None:
        __tracebackhide__ = True
        from sweep.errors import RequestError

        try:
            compared(words, reference)
        except RequestError as error:
            # its text says what to do; where it was raised does not
            pytest.fail(f"{words}: {error}", pytrace=False)

    def compared(words: str, reference: str | Path) -> None:
        __tracebackhide__ = True
        from sweep.atlas.dataset import run
        from sweep.checks.compare import compare
        from sweep.checks.comparison_report import in_words
        from sweep.files.reading import open_atlas
        from sweep.request.spec import SweepSpec
        from sweep.runs.run import run_to_file

        path = folder / reference
        first, *changes = shlex.split(words)
        # a spec in a file stands beside the test, like the reference
        spec = SweepSpec.from_words(folder / first if first.endswith(".toml") else first, changes)
        if request.config.getoption(_OPTION):
            command = f"eulerdisk run {words} -o {Path(reference).as_posix()}"
            run_to_file(spec, path, overwrite=True, command=command)
            pytest.skip(f"{reference} written anew")
        if not path.exists():
            pytest.fail(f"{path} does not exist: pytest {_OPTION} writes it", pytrace=False)
        with open_atlas(path) as trusted:
            comparison = compare(run(spec), trusted)
        if not comparison.same:
            pytest.fail(f"{words}: not as in {reference}\n{in_words(comparison)}", pytrace=False)

    return check
