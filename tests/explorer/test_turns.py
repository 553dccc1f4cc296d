"""One thread at a time calls the kernels of maps and reads the file, whatever is asked at once."""

import json
from concurrent.futures import ThreadPoolExecutor, wait

import pytest
from explorer_client import ROLLING, ask, post

import sweep
from sweep.explorer import lines, point, turns, window, window_files
from sweep.explorer.explorer import explore
from sweep.explorer.turns import SupersededError

PLACE = {"x": 2.5, "y": 0.02}
ASKED = {
    "window": (window, {"width": 8, "height": 6, "quantity": "peak_tilt"}),
    "point": (point, PLACE),
    "lines": (lines, {}),
    "data": (window_files, {"width": 8, "height": 6, "format": "csv"}),
}


@pytest.mark.parametrize("path", ASKED)
def test_kernels_of_maps_are_called_in_turns(path, monkeypatch):
    """Whoever computes cells has the lock of the kernels: they use all processors by themselves."""
    module, fields = ASKED[path]
    ordinary, held = module.compute, []

    def watched(*given, **named):
        held.append(turns.KERNELS._is_owned())
        return ordinary(*given, **named)

    monkeypatch.setattr(module, "compute", watched)
    with explore() as explorer:
        body = json.dumps({"view": ROLLING, **fields}).encode()
        assert ask(explorer.url, path, body).status == 200
    assert held
    assert all(held)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Return the file of a small atlas."""
    path = tmp_path_factory.mktemp("turns") / "rolling.nc"
    sweep.run_to_file(
        "rolling", path, roll_rate="2:4:6", tilt="0.1deg:10deg:5:log", method="exact", progress=False
    )
    return path


def test_a_file_is_read_in_turns_and_not_after_it_is_closed(file):
    """A window of stored cells waits while somebody else reads; what comes after the end reads nothing."""
    with explore(file) as explorer, ThreadPoolExecutor(1) as pool:
        stored = explorer._subject.stored
        view = json.loads(ask(explorer.url, "about").body)["bases"][0]["view"]
        asked = {"view": view, "width": 6, "height": 5, "quantity": "peak_tilt", "stored": True}
        with stored._lock:
            found = pool.submit(post, explorer.url, "window", **asked)
            assert not wait([found], timeout=0.5).done
        assert found.result()[1]["stored"].all()
    with pytest.raises(SupersededError), stored._reading():
        pytest.fail("A file that is closed was read.")
