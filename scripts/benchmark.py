"""How fast the engine is, against the field, against the machine and against an earlier record.

All contenders do the same task on the same cells with one thread each, in turns in one run, timed in processor
time, and stand in the table with the error that they reach. Seconds vary with the machine; ratios are what counts.
"""

import argparse
import sys
from pathlib import Path

from bench import field, figures, gpu, record, reduction, roofline, scaling


def main() -> int:
    """Run the benchmark; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer cells and repeats: one or two minutes")
    parser.add_argument("--repeats", type=int, help="pairs per contender (default: 5, quick 3)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write what was measured")
    parser.add_argument(
        "--figures", type=Path, metavar="FOLDER", help="draw work-precision.png and scaling.png"
    )
    parser.add_argument(
        "--readme", action="store_true", help="put the recorded table into the README, and end"
    )
    parser.add_argument(
        "--check", action="store_true", help="exit 1 if a ratio is a fifth worse than in docs/benchmark.json"
    )
    given = parser.parse_args()
    if given.readme:
        record.write_readme(record.read())
        return 0
    repeats = given.repeats or (3 if given.quick else 5)
    found = {
        "machine": record.machine(),
        "quick": given.quick,
        "kernel": roofline.measure(given.quick, repeats),
        "scaling": scaling.measure(given.quick, repeats),
        "run": scaling.whole_run(given.quick, repeats),
        "reduction": reduction.measure(given.quick, repeats),
        "field": field.measure(given.quick, repeats),
    }
    on_device = gpu.measure(repeats)
    if on_device is not None:
        found["cuda"] = on_device
    print(record.text(found))
    if given.json:
        record.write(found, given.json)
    if given.figures:
        given.figures.mkdir(parents=True, exist_ok=True)
        figures.work_precision(found, given.figures / "work-precision.png")
        figures.scaling(found, given.figures / "scaling.png")
    return record.report_losses(found, record.read()) if given.check else 0


if __name__ == "__main__":
    sys.exit(main())
