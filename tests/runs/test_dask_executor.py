"""Blocks computed by dask workers: the same bytes from any worker, even after one dies."""

import gc
import logging
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from messages import assert_facts, refused

from sweep.engine.compute import measure_block
from sweep.errors import FailedBlocksError, StoppedError
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

CHECKOUT = Path(__file__).parents[2]
WORDS = ["rolling", "roll_rate=0.5:4:160", "tilt=0.01deg:60deg:100:log"]

_CLUSTER = """
import sys
if __name__ == "__main__":
    from distributed import LocalCluster
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, *(worker.pid for worker in cluster.workers.values()), flush=True)
        sys.stdin.read()
"""


@pytest.fixture
def cluster(tmp_path_factory):
    """Return the address of a scheduler with two worker processes, and their process ids."""
    folder = tmp_path_factory.mktemp("cluster")
    script = folder / "cluster.py"
    script.write_text(_CLUSTER)
    process = subprocess.Popen(
        [sys.executable, script],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    address, *workers = process.stdout.readline().split()
    yield address, [int(worker) for worker in workers]
    process.communicate("", timeout=300)


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_killed_worker_costs_its_block(cluster, tmp_path, monkeypatch):
    """If one of two workers is killed after the first blocks, the bytes still equal a local run's."""
    pytest.importorskip("distributed")
    address, workers = cluster
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    spec = SweepSpec.from_words(WORDS[0], WORDS[1:])
    run_to_file(spec, tmp_path / "here.nc", command=f"eulerdisk run {' '.join(WORDS)} -o a.nc")
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "sweep",
            "run",
            *WORDS,
            "--dask",
            address,
            "--block-cells",
            "200",
            "-o",
            "a.nc",
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    while len(list(tmp_path.glob("a.nc.run/blocks/*.block"))) < 5:
        assert process.poll() is None
        time.sleep(0.01)
    os.kill(workers[0], signal.SIGKILL)
    assert len(list(tmp_path.glob("a.nc.run/blocks/*.block"))) < 80
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert err.endswith("eulerdisk: a.nc: 16000 cells\n")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "here.nc").read_bytes()
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.nc", "here.nc"]


def test_no_scheduler(tmp_path, monkeypatch):
    """An address without a scheduler is refused with advice to start one; nothing is left."""
    pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    monkeypatch.setattr(dask_executor, "_TIMEOUT", 0.5)
    spec = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
    with refused("--dask", "127.0.0.1:1", "dask worker ADDRESS"):
        run_to_file(spec, tmp_path / "a.nc", executor=dask_executor.on_cluster("tcp://127.0.0.1:1"))
    assert list(tmp_path.iterdir()) == []


def test_an_address_without_a_port(tmp_path, capsys):
    """It is refused at once, and no client is left to clean up."""
    pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    # Dask waits half a minute for a scheduler that it cannot find.
    spec, began = SweepSpec(tilt="1deg:5deg:20", roll_rate=3), time.monotonic()
    with refused("--dask", "nonsense", "missing port"):
        run_to_file(spec, tmp_path / "a.nc", executor=dask_executor.on_cluster("nonsense"))
    gc.collect()
    assert time.monotonic() - began < 25
    assert "Traceback" not in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_cluster_without_workers_says_so(monkeypatch, tmp_path):
    """A run without a worker says that it is waiting for one."""
    pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    said = []
    monkeypatch.setattr(Client, "scheduler_info", lambda _: {"workers": {}})
    monkeypatch.setattr(dask_executor, "_connect", lambda _: Client(None, "finished"))
    monkeypatch.setattr(dask_executor, "_compute_blocks", lambda *_: iter(()))
    with pytest.raises(StoppedError):
        run_to_file(
            SweepSpec(tilt="1deg:5deg:20", roll_rate=3),
            tmp_path / "a.nc",
            executor=dask_executor.on_cluster("tcp://here:1", said.append),
        )
    (line,) = said
    assert_facts(line, "no workers", "`dask worker tcp://here:1`")


def test_dask_that_is_not_installed(monkeypatch):
    """Without the extra, --dask says what to install."""
    from sweep.runs import dask_executor

    monkeypatch.setitem(sys.modules, "distributed", None)
    with refused("--dask", "distributed", "pip install distributed"):
        dask_executor.on_cluster("tcp://127.0.0.1:8786")


class Future:
    """A finished task of a cluster."""

    def __init__(self, number, problem=None, status="finished"):
        self.key, self.problem, self.status = f"task-{number}", problem, status

    def exception(self):
        """Return the reason of its failure."""
        return self.problem

    def release(self):
        """Release the task."""


class Client:
    """A cluster that has computed everything except one block."""

    loop = None

    def __init__(self, problem, status):
        self.problem, self.status = problem, status

    def scheduler_info(self):
        """Return the workers."""
        return {"workers": {"one": {}}}

    def map(self, work, folders, fingerprints, numbers, **_):
        """Compute all blocks except the third."""
        from sweep.runs import dask_executor

        futures = []
        for number, folder in zip(numbers, folders, strict=True):
            if number != 2:
                journal = dask_executor.Journal.at(Path(folder))
                journal.keep(number, measure_block(journal.spec, journal.spans[number]))
            futures.append(Future(number, self.problem, self.status) if number == 2 else Future(number))
        return futures

    def close(self):
        """Close nothing."""


class Completed:
    """The tasks in reverse order of submission."""

    def __init__(self, futures, loop):
        self.futures = list(futures)

    def count(self):
        """Return the number of tasks."""
        return len(self.futures)

    def next_batch(self, block):
        """Return one task."""
        return [self.futures.pop()]


@pytest.mark.parametrize(
    ("problem", "ended", "facts"),
    [
        (KeyError("worker died"), "error", ["1 of 4 blocks (2)", "KeyError('worker died')"]),
        (None, "cancelled", ["scheduler", "1 of 4 blocks"]),
    ],
)
def test_blocks_that_keep_failing_do_not_stop_the_others(tmp_path, monkeypatch, problem, ended, facts):
    """Failed blocks end with status 1 and a reason, after all others are stored; the run can resume."""
    distributed = pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    monkeypatch.setattr(dask_executor, "_connect", lambda _: Client(problem, ended))
    monkeypatch.setattr(distributed, "as_completed", Completed)
    spec = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
    with refused(*facts, error=FailedBlocksError) as caught:
        run_to_file(
            spec, tmp_path / "a.nc", block_cells=5, executor=dask_executor.on_cluster("tcp://nowhere:1")
        )
    assert caught.value.status == 1
    assert len(list(tmp_path.glob("a.nc.run/blocks/*.block"))) == 3
    run_to_file(spec, tmp_path / "a.nc")
    assert [each.name for each in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.parametrize("problem", ["connection", "time", "cancelled"])
def test_a_lost_scheduler_is_told_in_a_sentence(tmp_path, monkeypatch, problem):
    """For each error of dask the message says that the scheduler is gone and how to resume."""
    distributed = pytest.importorskip("distributed")
    from sweep.runs import dask_executor

    problems = {
        "connection": distributed.comm.CommClosedError("in <TCP>"),
        "time": TimeoutError(),
        "cancelled": CancelledError(),
    }
    log = logging.getLogger("distributed.client")

    class Lost(Client):
        def map(self, *_, **__):
            assert log.disabled
            raise problems[problem]

    monkeypatch.setattr(dask_executor, "_connect", lambda _: Lost(None, "lost"))
    spec = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
    with refused("4 of 4 blocks", error=FailedBlocksError):
        run_to_file(
            spec, tmp_path / "a.nc", block_cells=5, executor=dask_executor.on_cluster("tcp://nowhere:1")
        )
    assert not log.disabled
