"""A run of tests as a whole: how many of how many ran, how much they write, and what stays behind.

A plugin of pytest that `conftest` registers, in each process of tests and in the one that directs them.
"""

import os
import re
import shutil
import tempfile

import pytest

#: Bytes that one test may write; bytes that must be free before the first one begins.
MOST_WRITTEN, LEAST_FREE = 200e6, 1e9

#: Where programs that tests start keep temporary files, in the folder of all tests.
PROGRAMS = "of-programs"


class WholeRun:
    """What is known of a run: the names of all tests, of those that ran, and of those that failed."""

    def __init__(self, config):
        # a worker of pytest-xdist has its input, and another process counts
        self.directs = not hasattr(config, "workerinput")
        self.all, self.ran, self.failed = set(), set(), set()

    def pytest_sessionstart(self, session):
        """Refuse a full disk, and let programs keep their temporary files where the tests do."""
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
        """Note all tests of one process."""
        self.all.update(item.nodeid for item in session.items)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids):
        """Note all tests of several processes."""
        self.all.update(ids)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        """Fail a test that writes more than a test may."""
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
        """Note a test that ran; one that ended its process is reported as failed."""
        self.ran.add(report.nodeid)
        if report.failed:
            self.failed.add(report.nodeid)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session, exitstatus):
        """Remove what tests that passed have left, and never call a run green that left tests out."""
        if not self.directs:
            return
        if self.missing(session.config) and exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
        remove_all_but(session.config._tmp_path_factory.getbasetemp(), self.failed)

    def missing(self, config):
        """Return how many tests did not run though they were to."""
        return 0 if config.option.collectonly else len(self.all - self.ran)

    # the outermost: behind the list of what failed
    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(self, terminalreporter, config):
        """Tell how many of how many tests ran, and how to repeat what was drawn."""
        yield
        if self.directs and not config.option.collectonly:
            terminalreporter.write_line(f"{len(self.all & self.ran)} of {len(self.all)} tests ran")
        if config.option.seed:
            terminalreporter.write_line(f"drawn with --seed {config.option.seed}")


def size_on_disk(folder):
    """Return the bytes that files below a folder take, which may change meanwhile."""
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.lstat(os.path.join(place, name)).st_blocks * 512
            except OSError:
                continue
    return total


def remove_all_but(base, failed):
    """Remove a folder of temporary files except the folders of failed tests; pytest names these after the test."""
    if not base.exists():
        # pytest has removed it
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
