"""The pytest fixture `eulerdisk_atlas`: run a spec and compare the atlas with a reference file, or rewrite the file.

::

    def test_rolling(eulerdisk_atlas):
        eulerdisk_atlas("rolling roll_rate=2:4:20 tilt=0.1deg:20deg:10:log", "data/rolling.nc")

``pytest --eulerdisk-regen`` rewrites the reference files instead. Values may differ as far as the two atlases state;
``eulerdisk_atlas(words, file, tolerances={"tilt_max": 1e-6})`` allows other differences, and ``exact=True`` none.
"""

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

_OPTION = "--eulerdisk-regen"

#: Messages about a reference file.
_WRITTEN = " was written"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that rewrites the reference files."""
    group = parser.getgroup("eulerdisk")
    group.addoption(_OPTION, action="store_true", help="rewrite the reference atlases of eulerdisk_atlas")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say which reference files were written: a skipped test alone says it only to those who ask."""
    for report in terminalreporter.stats.get("skipped", ()) if config.getoption(_OPTION) else ():
        if (said := str(report.longrepr[2]).removeprefix("Skipped: ")).endswith(_WRITTEN):
            terminalreporter.write_line(f"eulerdisk: {said}")


@pytest.fixture
def eulerdisk_atlas(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that runs a spec and compares the atlas with a reference file.

    Its arguments are the words of ``eulerdisk run``, as one text, and the path of the file, relative to the folder of
    the test; `tolerances` and `exact` are those of `sweep.checks.compare.compare`. It fails the test with the report of
    ``eulerdisk compare`` if the two differ.
    """
    folder = request.path.parent

    def check(
        words: str,
        reference: str | Path,
        *,
        tolerances: Mapping[str, float | str] | None = None,
        exact: bool = False,
    ) -> None:
        __tracebackhide__ = True
        from sweep.platforms import check_system

        check_system()
        from sweep.checks.compare import compare
        from sweep.checks.comparison_report import in_words
        from sweep.errors import RequestError
        from sweep.files.reading import open_atlas
        from sweep.request.spec import SweepSpec
        from sweep.runs.in_memory import run
        from sweep.runs.run import run_to_file

        path = folder / reference
        first, *changes = shlex.split(words)
        wrong = ""
        try:
            # the path of a spec file is relative to the folder of the test too
            spec = SweepSpec.from_words(folder / first if first.endswith(".toml") else first, changes)
            if request.config.getoption(_OPTION):
                command = f"eulerdisk run {words} -o {Path(reference).as_posix()}"
                run_to_file(spec, path, overwrite=True, command=command)
                pytest.skip(f"{reference}{_WRITTEN}")
            if not path.exists():
                pytest.fail(f"{path} does not exist: pytest {_OPTION} writes it", pytrace=False)
            with open_atlas(path) as trusted:
                comparison = compare(run(spec), trusted, tolerances=tolerances, exact=exact)
        except RequestError as error:
            wrong = f"{words}: {error}"
        if wrong:
            # not where the error is handled: pytest would print both, and the message says what to do
            pytest.fail(wrong, pytrace=False)
        if not comparison.same:
            pytest.fail(f"{words}: differs from {reference}\n{in_words(comparison)}", pytrace=False)

    return check
