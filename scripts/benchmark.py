"""How fast the engine is, against the field, against the machine and against an earlier record.

All contenders do the same task on the same cells with one thread each, in turns in one run, timed in processor
time, and stand in the table with the error that they reach. Seconds vary with the machine; ratios are what counts.
"""

import argparse
import sys
from pathlib import Path

from bench import (
    bodies,
    field,
    figures,
    gpu,
    losses,
    planned,
    record,
    reduction,
    roofline,
    scaling,
    start,
    systems,
    table,
    whole,
)


def main() -> int:
    """Run the benchmark; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer cells and repeats: some minutes")
    parser.add_argument("--repeats", type=int, help="pairs per contender (default: 5, quick 3)")
    parser.add_argument("--record", action="store_true", help="keep it in docs/benchmark for this processor")
    parser.add_argument(
        "--figures", type=Path, metavar="FOLDER", help="draw work-precision.png and scaling.png"
    )
    parser.add_argument(
        "--page", action="store_true", help="put the table of all records into docs/speed.md, and end"
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="exit 1 if a ratio is a fifth worse than in the record of this kind of processor in docs/benchmark; "
        "where it has none, half as good as in any of them",
    )
    given = parser.parse_args()
    if given.page:
        table.write_page(record.read_all())
        return 0
    repeats = given.repeats or (3 if given.quick else 5)
    found = {
        "machine": record.machine(),
        "quick": given.quick,
        "kernel": roofline.measure(given.quick, repeats),
        "scaling": scaling.measure(given.quick, repeats),
        "whole": whole.measure(given.quick),
        "start": start.measure(repeats),
        "plan": planned.measure(given.quick),
        "reduction": reduction.measure(given.quick, repeats),
        "field": field.measure(given.quick, repeats),
        "losses": losses.measure(given.quick, repeats),
        "bodies": bodies.measure(given.quick, repeats),
        "systems": systems.measure(given.quick, repeats),
    }
    on_device = gpu.measure(repeats)
    if on_device is not None:
        found["cuda"] = on_device
    print(table.text(found))
    # what it is checked against was recorded before
    status = record.report_losses(found, record.read_all()) if given.check else 0
    if given.record:
        record.write(found)
    if given.figures:
        given.figures.mkdir(parents=True, exist_ok=True)
        figures.work_precision(found, given.figures / "work-precision.png")
        figures.scaling(found, given.figures / "scaling.png")
    return status


if __name__ == "__main__":
    sys.exit(main())
