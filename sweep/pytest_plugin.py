"""The pytest fixture `eulerdisk_atlas`, which runs a spec and compares the atlas with a reference file.

::

    def test_rolling(eulerdisk_atlas):
        eulerdisk_atlas("rolling roll_rate=2:4:20 tilt=0.1deg:20deg:10:log", "data/rolling.nc")

``pytest --eulerdisk-regen`` rewrites the reference files instead. Values may differ within the accuracy that the two
atlases state; ``eulerdisk_atlas(words, file, tolerances={"tilt_max": 1e-6})`` sets other tolerances, and ``exact=True``
allows no difference.
"""

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

_OPTION = "--eulerdisk-regen"

#: End of the message about a rewritten reference file.
_WRITTEN = " was written"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that rewrites the reference files."""
    group = parser.getgroup("eulerdisk")
    group.addoption(_OPTION, action="store_true", help="rewrite the reference atlases of eulerdisk_atlas")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Report which reference files were written: pytest shows the reason for a skip only on request."""
    for report in terminalreporter.stats.get("skipped", ()) if config.getoption(_OPTION) else ():
        if (said := str(report.longrepr[2]).removeprefix("Skipped: ")).endswith(_WRITTEN):
            terminalreporter.write_line(f"eulerdisk: {said}")


@pytest.fixture
def eulerdisk_atlas(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that runs a spec and compares the atlas with a reference file.

    Its arguments are the words of ``eulerdisk run`` as one string, and the path of the file relative to the folder of
    the test; `tolerances` and `exact` are as in `sweep.checks.compare.compare`. If the two differ, the test fails with
    the report of ``eulerdisk compare``.
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
            # the path of a spec file is also relative to the folder of the test
            spec = SweepSpec.from_words(folder / first if first.endswith(".toml") else first, changes)
            if request.config.getoption(_OPTION):
                command = f"eulerdisk run {words} -o {Path(reference).as_posix()}"
                run_to_file(spec, path, overwrite=True, command=command)
                pytest.skip(f"{reference}{_WRITTEN}")
            if not path.exists():
                pytest.fail(f"{path} does not exist; create it with pytest {_OPTION}", pytrace=False)
            with open_atlas(path) as trusted:
                comparison = compare(run(spec), trusted, tolerances=tolerances, exact=exact)
        except RequestError as error:
            wrong = f"{words}: {error}"
        if wrong:
            # outside of the except block, because pytest would print both errors; the message has the hint
            pytest.fail(wrong, pytrace=False)
        if not comparison.same:
            pytest.fail(f"{words}: differs from {reference}\n{in_words(comparison)}", pytrace=False)

    return check
