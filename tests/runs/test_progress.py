"""All stages of a run are reported, and those with a known pace count from the start."""

import itertools

import pytest

from sweep.engine.compute import measure_block
from sweep.progress.timetable import COMPUTING, SEARCHING
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, executor, forecast
from sweep.runs.forecast import READING, WRITING
from sweep.runs.run import run_to_file

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)


def names(heard):
    """Return the stages in order of appearance."""
    return [name for name, _ in itertools.groupby(each.stage for each in heard)]


def test_no_stage_of_a_run_is_left_out(tmp_path, monkeypatch):
    """Fresh, resumed and assembled runs report every stage, its last cell, and 0 s only at the end."""

    def breaking(spec, span):
        if span.start == 10:
            raise KeyboardInterrupt
        return measure_block(spec, span)

    fresh, again, part, assembled = [], [], [], []
    run_to_file(SPEC, tmp_path / "a.nc", block_cells=5, progress=fresh.append)
    assert names(fresh) == [COMPUTING, SEARCHING]
    with monkeypatch.context() as patch:
        patch.setattr(executor, "measure_block", breaking)
        with pytest.raises(KeyboardInterrupt):
            run_to_file(SPEC, tmp_path / "b.nc", block_cells=5)
    run_to_file(SPEC, tmp_path / "b.nc", progress=again.append)
    assert names(again) == [READING, COMPUTING, WRITING, SEARCHING]
    assert [each.done for each in again if each.stage == COMPUTING] == [10, 15, 20]
    elsewhere = []
    run_to_file(SPEC, tmp_path / "d.nc", executor=executor.local(None), progress=elsewhere.append)
    assert names(elsewhere) == [COMPUTING, WRITING, SEARCHING]
    folder = array_jobs.prepare(SPEC, tmp_path / "c.nc", block_cells=5).folder
    array_jobs.compute_part(folder, 2, 2, progress=part.append)
    assert [(each.done, each.size) for each in part if each.stage == COMPUTING] == [
        (0, 10),
        (5, 10),
        (10, 10),
    ]
    array_jobs.compute_part(folder, 1, 2)
    array_jobs.assemble(folder, progress=assembled.append)
    assert names(assembled) == [READING, WRITING, SEARCHING]
    for heard in (fresh, again, assembled):
        assert all(each.seconds is None or each.seconds > 0.0 or each.done == each.size for each in heard)
        ends = {each.stage: (each.done, each.size) for each in heard if each.stage in (COMPUTING, WRITING)}
        assert set(ends.values()) == {(20, 20)}


@pytest.mark.compiled
def test_the_cells_of_the_bisection_are_about_those_that_are_expected(monkeypatch):
    """The estimate for a refined boundary is right within a factor of two."""
    spec = SweepSpec.preset("rolling").replace(
        roll_rate="2:4:60", tilt="0.5deg:5deg:50", boundary="refined:1e-6", duration=5.0
    )
    counted, compute = [], "sweep.atlas.boundary.compute"
    original = __import__("sweep.atlas.boundary", fromlist=["compute"]).compute

    def counting(spec, starts, **options):
        counted.append(starts["tilt"].size)
        return original(spec, starts, **options)

    import sweep

    monkeypatch.setattr(compute, counting)
    sweep.run(spec)
    assert 0.5 < forecast.bisected_cells(spec) / sum(counted) < 2.0
    assert forecast.bisected_cells(spec.replace(boundary="grid")) == 0
