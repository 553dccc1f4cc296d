"""Compile ahead of time: `warmup`."""

import time


def warmup() -> None:
    """Compile the kernels into the cache, for images and clusters, and say where it is.

    EULERDISK_CACHE_DIR names another folder for it. The kernels fit the processor that compiles them.
    """
    from sweep.atlas.dataset import run
    from sweep.engine.compiled import cache_folder, check_cache
    from sweep.request.spec import SweepSpec
    from sweep.schema import METHODS

    for method in METHODS:
        began = time.perf_counter()
        run(SweepSpec(tilt="1deg", roll_rate=3.0, method=method))
        print(f"{method:<6} ready after {time.perf_counter() - began:.1f} s")
    check_cache()
    print(f"cache  {cache_folder()}")
