"""The Python functions accept or refuse in a sentence whatever is given in place of an atlas."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sweep

SMALL = {"roll_rate": "2:4:3", "tilt": "0.1deg,1deg"}

#: Things given instead of an atlas, each made from an atlas.
GIVEN = {
    "nothing": lambda atlas: None,
    "a number": lambda atlas: 3,
    "an array": lambda atlas: atlas["tilt_max"],
    "the class of datasets": lambda atlas: xr.Dataset,
    "no variables": lambda atlas: xr.Dataset(),
    "no attributes": lambda atlas: atlas.drop_attrs(),
    "a file that is not there": lambda atlas: "no.nc",
    "a path of 4,000 characters": lambda atlas: Path("x" * 4000),
    "a folder": lambda atlas: Path(),
    "no cells": lambda atlas: atlas.isel(roll_rate=slice(0, 0)),
    "no rows": lambda atlas: atlas.isel(tilt=[]),
    "no dimensions": lambda atlas: atlas.isel(roll_rate=0, tilt=0),
    **{
        f"{name} of {kind}": lambda atlas, name=name, kind=kind: atlas.assign(
            {name: atlas[name].astype(kind)}
        )
        for name in ("ending", "stability", "tilt_max", "boundary_roll_rate", "boundary_roll_rate_halfwidth")
        for kind in ("U", "O", "complex128", "bool", "datetime64[ns]", "float32", "uint64")
    },
    **{
        f"axis of {kind}": lambda atlas, kind=kind: atlas.assign_coords(
            roll_rate=atlas["roll_rate"].astype(kind)
        )
        for kind in ("U", "O", "complex128", "datetime64[ns]", "int16")
    },
    "a text as spec": lambda atlas: atlas.assign_attrs(sweep_spec=3),
    "a list as spec": lambda atlas: atlas.assign_attrs(sweep_spec="[]"),
    "a title that is none": lambda atlas: atlas.assign_attrs(title=np.arange(3)),
}

#: The functions to which they are given.
DOORS = {
    "verify": sweep.verify,
    "compare": lambda given: sweep.compare(given, given),
    "findings": sweep.findings,
    "reclassify": lambda given: sweep.reclassify(given, "departure:2deg"),
    "repr": lambda given: repr(given.eulerdisk),
    "html": lambda given: given.eulerdisk._repr_html_(),
    "boundary": lambda given: given.eulerdisk.boundary(),
    "critical": lambda given: given.eulerdisk.critical,
    "stable": lambda given: given.eulerdisk.stable,
    "cell": lambda given: given.eulerdisk.cell(roll_rate=3.0, tilt=0.01),
    "interp": lambda given: given.eulerdisk.interp(roll_rate=3.0),
    "spec": lambda given: given.eulerdisk.spec,
    "simulate": lambda given: given.eulerdisk.simulate(roll_rate=3.0, tilt=0.01),
    "plot": lambda given: given.eulerdisk.plot(),
}

#: Functions that accept anything; the others are called on a dataset.
FUNCTIONS = ("verify", "compare", "findings", "reclassify")


def _raised(use, given):
    try:
        use(given)
    except Exception as problem:
        return problem
    return None


@pytest.mark.release
def test_they_answer_or_refuse_in_a_sentence(tmp_path, monkeypatch):
    """They raise no other errors, and no message repeats a path of thousands of characters."""
    monkeypatch.chdir(tmp_path)
    atlas = sweep.run("rolling", **SMALL)
    for door, use in DOORS.items():
        for name, make in GIVEN.items():
            given = make(atlas)
            if not isinstance(given, xr.Dataset) and door not in FUNCTIONS:
                continue
            problem = _raised(use, given)
            assert problem is None or isinstance(problem, sweep.RequestError), (door, name, problem)
            assert len(str(problem)) < 1200, (door, name)
    assert list(tmp_path.iterdir()) == []


#: Things that are no request, path or list of words, and a name of 4,000 characters.
STRANGE = (
    3,
    b"a.nc",
    2.5,
    ["a.nc"],
    xr.Dataset(),
    xr.Dataset,
    np.zeros(3),
    {"a": 1},
    "x" * 4000,
    Path("x" * 4000),
    None,
)

#: Functions that take a request, a path, words or a number of threads.
REQUESTS = {
    "open_atlas": sweep.open_atlas,
    "run": sweep.run,
    "run_to_file": lambda given: sweep.run_to_file("rolling", given, **SMALL),
    "spec of run_to_file": lambda given: sweep.run_to_file(given, "a.nc"),
    "simulate": lambda given: sweep.simulate(given, duration=0.1),
    "from_toml": sweep.SweepSpec.from_toml,
    "preset": sweep.SweepSpec.preset,
    "spec of from_words": lambda given: sweep.SweepSpec.from_words(given, []),
    "words of from_words": lambda given: sweep.SweepSpec.from_words("rolling", given),
    "starts": lambda given: sweep.SweepSpec(starts=given),
    "threads": lambda given: sweep.run("rolling", **SMALL, threads=given),
    "save": lambda given: sweep.save(sweep.run("rolling", **SMALL), given),
    "animate": lambda given: sweep.simulate(roll_rate=3.0, duration=0.1).eulerdisk.animate(given),
}


def test_strange_requests_are_refused_in_a_sentence(tmp_path, monkeypatch):
    """They raise no other errors, repeat no name of thousands of characters, and write nothing."""
    monkeypatch.chdir(tmp_path)
    for door, use in REQUESTS.items():
        for given in STRANGE:
            problem = _raised(use, given)
            assert problem is None or isinstance(problem, sweep.RequestError), (door, given, problem)
            assert len(str(problem)) < 1200, (door, given)
    assert list(tmp_path.iterdir()) == []


def test_a_path_is_an_atlas(tmp_path):
    """`verify` and `compare` accept a file, as text or Path, with the same result as for its contents."""
    spec = sweep.SweepSpec.preset("rolling", **SMALL)
    path = tmp_path / "a.nc"
    sweep.run_to_file(spec, path)
    with sweep.open_atlas(path) as atlas:
        told = sweep.verify(atlas)
        assert sweep.verify(path).drop_attrs().identical(told.drop_attrs())
        assert sweep.compare(str(path), path) == sweep.compare(atlas, atlas)
    # Compared as text, because NaN differs from itself.
    assert repr(sweep.findings(sweep.verify(str(path)))) == repr(sweep.findings(told))
    # The file was closed, so it can be replaced.
    sweep.run_to_file(spec, path, overwrite=True)
