"""Blocks computed by the workers of dask: the same bytes, whoever computes them and whoever dies."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sweep.errors import FailedBlocksError, RequestError
from sweep.request.spec import SweepSpec
from sweep.runs.running import run_to_file

CHECKOUT = Path(__file__).parents[1]
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
    """Return the address of a scheduler with two worker processes, and their numbers."""
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
    process.communicate("", timeout=60)


@pytest.mark.compiled
def test_a_killed_worker_costs_its_block(cluster, tmp_path, monkeypatch):
    """Two workers, one of them killed with kill -9 after the first blocks: the bytes are those of a run here."""
    pytest.importorskip("distributed")
    address, workers = cluster
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    spec = SweepSpec.from_words(WORDS[0], WORDS[1:])
    run_to_file(spec, tmp_path / "here.nc", command="eulerdisk run " + " ".join(WORDS))
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
    while len(list(tmp_path.glob("a.nc.run/blocks/*.npz"))) < 5:
        assert process.poll() is None
        time.sleep(0.01)
    os.kill(workers[0], signal.SIGKILL)
    assert len(list(tmp_path.glob("a.nc.run/blocks/*.npz"))) < 80
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert err.endswith("eulerdisk: a.nc: 16000 cells\n")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "here.nc").read_bytes()
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.nc", "here.nc"]


def test_no_scheduler(tmp_path, monkeypatch):
    """An address where nobody answers is refused, with how to start one; nothing is left."""
    pytest.importorskip("distributed")
    from sweep.runs import cluster

    monkeypatch.setattr(cluster, "_PATIENCE", 0.5)
    spec = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
    with pytest.raises(RequestError, match=r"no dask scheduler answers.*dask worker"):
        run_to_file(spec, tmp_path / "a.nc", driver=cluster.on_cluster("tcp://127.0.0.1:1"))
    assert list(tmp_path.iterdir()) == []


def test_dask_that_is_not_installed(monkeypatch):
    """Without the extra, --dask says what to install."""
    from sweep.runs import cluster

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(RequestError, match=r"pip install 'eulerdisk\[dask\]'"):
        cluster.on_cluster("tcp://127.0.0.1:8786")


class Future:
    """A task of a cluster that has ended."""

    def __init__(self, number, problem):
        self.key, self.problem = f"task-{number}", problem
        self.status = "error" if problem else "finished"

    def exception(self):
        """Return why it failed."""
        return self.problem

    def release(self):
        """Let go of it."""


def test_blocks_that_keep_failing_do_not_stop_the_others(tmp_path, monkeypatch):
    """The blocks that the workers cannot compute are named with status 1, after all others are kept."""
    distributed = pytest.importorskip("distributed")
    from sweep.runs import cluster, driving

    class Client:
        loop = None

        def map(self, work, folders, fingerprints, numbers, **_):
            futures = []
            for number, folder in zip(numbers, folders, strict=True):
                problem = KeyError("worker died") if number == 2 else None
                if problem is None:
                    book = cluster.Journal.at(Path(folder))
                    book.keep(number, driving.compute(book.manifest.spec, book.spans[number]))
                futures.append(Future(number, problem))
            return futures

        def close(self):
            pass

    class Completed:
        def __init__(self, futures, loop):
            self.futures = list(futures)

        def count(self):
            return len(self.futures)

        def next_batch(self, block):
            return [self.futures.pop()]

    monkeypatch.setattr(cluster, "_connected", lambda _: Client())
    monkeypatch.setattr(distributed, "as_completed", Completed)
    spec = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)
    with pytest.raises(FailedBlocksError, match=r"1 of 4 blocks: 2; KeyError") as caught:
        run_to_file(spec, tmp_path / "a.nc", block_cells=5, driver=cluster.on_cluster("tcp://nowhere:1"))
    assert caught.value.status == 1
    assert len(list(tmp_path.glob("a.nc.run/blocks/*.npz"))) == 3
    run_to_file(spec, tmp_path / "a.nc")
    assert [each.name for each in tmp_path.iterdir()] == ["a.nc"]
