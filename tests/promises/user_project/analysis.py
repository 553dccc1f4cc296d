"""A user's strictly typed program that only knows `import sweep`."""

from pathlib import Path

import xarray as xr

import sweep


def report(status: sweep.Status) -> None:
    """Show progress in the user's own way."""
    left = "" if status.seconds is None else f", {status.seconds:.0f} s to go"
    print(f"{status.stage}: {status.done} of {status.size} {status.things}{left}")


def specification(radius: str) -> sweep.SweepSpec:
    """Return the request to compute."""
    rates = sweep.Range(2.0, 4.0, 30)
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate=rates, tilt="0.1deg:5deg:20")
    return spec.replace(radius=radius, criterion="departure:2deg")


def computed(spec: sweep.SweepSpec, path: Path) -> xr.Dataset:
    """Compute in memory and to a file, and compare the two."""
    atlas = sweep.run(spec, threads=1, progress=report)
    failures: sweep.Failures = sweep.run_to_file(spec, path, overwrite=True, progress=False)
    if failures.total:
        raise SystemExit("\n".join(failures.describe()))
    with sweep.open_atlas(path) as stored:
        comparison: sweep.Comparison = sweep.compare(stored, atlas, exact=True)
    if not comparison.identical:
        raise SystemExit(comparison.outcome)
    return atlas


def judged(atlas: xr.Dataset) -> xr.Dataset:
    """Return the atlas by another criterion, with its boundary refined."""

    def falls(cells: xr.Dataset) -> xr.DataArray:
        return cells["peak_tilt"] > 1.0

    by_function = sweep.reclassify(atlas, falls)
    assert by_function.attrs["criterion"]
    return sweep.refine(sweep.reclassify(atlas, "departure:1deg"), 1e-6, progress=None)


def asked(atlas: xr.Dataset) -> float:
    """Query an atlas through its accessor, whose type is also public."""
    view: sweep.Eulerdisk = atlas.eulerdisk
    share: float = float(view.stable.mean())
    cell: xr.Dataset = view.cell(roll_rate=2.5, tilt="1deg")
    motion: xr.Dataset = sweep.simulate(radius="12mm", tilt="1deg", duration=1.0)
    print(view.boundary().sizes, cell.sizes, motion.sizes, view.spec.fingerprint())
    return share


def main() -> None:
    """Run the whole program."""
    path = Path("typed.nc")
    try:
        atlas = computed(specification("12mm"), path)
    except sweep.RequestError as error:
        raise SystemExit(f"{error.message} {error.hint}") from error
    found: sweep.Findings = sweep.findings(sweep.verify(atlas))
    sweep.save(judged(atlas), "judged.nc", overwrite=True)
    print(found.passed, asked(atlas), sweep.__version__)


if __name__ == "__main__":
    main()
