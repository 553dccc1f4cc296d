"""Measure how fast the engine is, compared with other software, with the machine and with an earlier record.

All contenders do the same task on the same cells with one thread each, by turns in one run, timed in processor time,
and are listed with the error that they reach. Seconds vary with the machine, so only ratios count.
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
    parser.add_argument(
        "--record", action="store_true", help="store the result in docs/benchmark for this processor"
    )
    parser.add_argument(
        "--figures", type=Path, metavar="FOLDER", help="draw work-precision.png and scaling.png"
    )
    parser.add_argument(
        "--page", action="store_true", help="write the table of all records into docs/speed.md, and exit"
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="exit 1 if a ratio is a fifth worse than in the record of this kind of processor in docs/benchmark, "
        "or, if it has no record, less than half as good as in every record",
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
    # compares with what was recorded before this run
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
