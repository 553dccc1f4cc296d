"""What the process of an explorer takes of memory: no compiler, and no more for each file that it gives away."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from explorer_browser import served
from explorer_client import ROLLING, ask, post

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="needs the files of /proc"),
]

#: A window whose file takes 100 MB while it is made.
LARGE = {"view": ROLLING, "width": 900, "height": 600, "format": "netcdf"}


def test_kernels_are_compiled_by_another_process(tmp_path, monkeypatch):
    """With an empty cache the first motion is answered by a process that never loads Numba."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    with served() as server:
        losses = {"rolling_friction": 1e-3}
        _, arrays = post(server.url, "motion", view=ROLLING, x=2.5, y=0.02, losses=losses)
        assert arrays["time"].size > 100
        loaded = Path(f"/proc/{server.process.pid}/maps").read_text(encoding="utf-8")
    assert list(tmp_path.glob("*/trajectory-*.nbc"))
    assert "/numba/" not in loaded


def test_the_memory_of_a_file_is_given_back():
    """Every connection has a thread, and threads have heaps of their own: none keeps what a large file took."""
    with served() as server:
        # this loads what writes files
        ask(server.url, "data", json.dumps(LARGE | {"width": 20, "height": 20}).encode())
        before = server.memory
        after = []
        for _ in range(3):
            assert ask(server.url, "data", json.dumps(LARGE).encode()).status == 200
            after.append(server.memory)
    assert max(after) - before < 40.0, after


def test_threads_keep_nothing_of_large_windows():
    """After a large block was freed the heaps of the threads that answer would keep blocks of that size: 78 MB here."""
    with served() as server:
        ask(server.url, "data", json.dumps(LARGE | {"width": 20, "height": 20}).encode())
        ask(server.url, "data", json.dumps(LARGE | {"width": 1000, "height": 700, "format": "csv"}).encode())
        before = server.memory
        fields = {"view": ROLLING, "width": 1400, "height": 900, "quantity": "peak_tilt", "lane": "fine"}
        with ThreadPoolExecutor(8) as clients:
            for answer in clients.map(
                lambda n: post(server.url, "window", client=f"c{n}", number=1, **fields), range(8)
            ):
                assert answer
        assert server.memory - before < 55.0


def test_a_refused_question_gives_memory_back_too(monkeypatch):
    """What is asked for in vain has taken memory as well."""
    from sweep.explorer import answers

    given_back = []
    monkeypatch.setattr(answers, "give_back", lambda: given_back.append(1))
    all_answers = answers.Answers(None)
    for number, path in enumerate(("motion", "explain", "data"), start=1):
        with pytest.raises(Exception, match="view"):
            all_answers.posted[path]({}, lambda: False)
        assert len(given_back) == number
