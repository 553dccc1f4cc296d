"""A whole test run: how many tests ran, how much they write, and what they leave.

A pytest plugin that `conftest` registers in each test process and in the controlling one.
"""

import os
import re
import shutil
import tempfile

import pytest

#: Bytes that one test may write; bytes that must be free before the first test.
MOST_WRITTEN, LEAST_FREE = 200e6, 1e9

#: Folder of temporary files for programs that tests start, in the folder of all tests.
PROGRAMS = "of-programs"


class WholeRun:
    """The names of all tests of a run, of those that ran, and of those that failed."""

    def __init__(self, config):
        # A worker of pytest-xdist has workerinput; the controlling process counts.
        self.directs = not hasattr(config, "workerinput")
        self.all, self.ran, self.failed = set(), set(), set()

    def pytest_sessionstart(self, session):
        """Refuse a full disk, and let programs put their temporary files where the tests do."""
        if not self.directs:
            return
        base = session.config._tmp_path_factory.getbasetemp()
        free = shutil.disk_usage(base).free
        if free < LEAST_FREE:
            pytest.exit(
                f"The tests need {LEAST_FREE / 1e9:.0f} GB for their files; {free / 1e9:.2f} GB are free in "
                f"{base.parent}. Free some, or set TMPDIR to a folder on another disk.",
                returncode=2,
            )
        (base / PROGRAMS).mkdir(exist_ok=True)
        os.environ["TMPDIR"] = str(base / PROGRAMS)
        tempfile.tempdir = None

    def pytest_collection_finish(self, session):
        """Record all tests of one process."""
        self.all.update(item.nodeid for item in session.items)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids):
        """Record all tests of several processes."""
        self.all.update(ids)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        """Fail a test that writes more than allowed."""
        report = yield
        folder = getattr(item, "funcargs", {}).get("tmp_path") if call.when == "call" else None
        written = size_on_disk(folder) if folder else 0
        if report.passed and written > MOST_WRITTEN:
            report.outcome = "failed"
            report.longrepr = (
                f"{item.nodeid} wrote {written / 1e6:.0f} MB, more than {MOST_WRITTEN / 1e6:.0f} MB"
            )
        return report

    def pytest_runtest_logreport(self, report):
        """Record a test that ran; one that ended its process is reported as failed."""
        self.ran.add(report.nodeid)
        if report.failed:
            self.failed.add(report.nodeid)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session, exitstatus):
        """Remove the files of passed tests, and never report success if tests were missed."""
        if not self.directs:
            return
        if self.missing(session.config) and exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
        remove_all_but(session.config._tmp_path_factory.getbasetemp(), self.failed)

    def missing(self, config):
        """Return the number of selected tests that did not run."""
        return 0 if config.option.collectonly else len(self.all - self.ran)

    # Outermost, so it prints after the list of failures.
    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(self, terminalreporter, config):
        """Print how many tests ran, and how to repeat the random draws."""
        yield
        if self.directs and not config.option.collectonly:
            terminalreporter.write_line(f"{len(self.all & self.ran)} of {len(self.all)} tests ran")
        if config.option.seed:
            terminalreporter.write_line(f"drawn with --seed {config.option.seed}")


def size_on_disk(folder):
    """Return the disk usage of files below a folder, which may change meanwhile."""
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.lstat(os.path.join(place, name)).st_blocks * 512
            except OSError:
                continue
    return total


def remove_all_but(base, failed):
    """Remove a folder of temporary files except the folders of failed tests, named by pytest after the tests."""
    if not base.exists():
        # Pytest has removed it.
        return
    names = {re.sub(r"\W", "_", test.rpartition("::")[2])[:30] for test in failed}
    for place in (*base.glob("popen-*"), base):
        for each in list(place.iterdir()):
            is_kept = each.is_dir() and (
                each.name.rstrip("0123456789") in names or each.name.startswith("popen-")
            )
            if each.is_symlink() or not each.is_dir():
                each.unlink(missing_ok=True)
            elif not is_kept or not any(each.iterdir()):
                shutil.rmtree(each, ignore_errors=True)
    if not any(base.iterdir()):
        base.rmdir()
