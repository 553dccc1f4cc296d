"""The command that compiles kernels before they are needed, with one process per processor: `warmup`."""

import multiprocessing
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

from sweep import platforms
from sweep.commands.terminal import show

if TYPE_CHECKING:
    from sweep.model.kernel import Kernel

#: Tasks by name, for other processes: each uses kernels, which compiles them.
Tasks = Mapping[str, Callable[[], object]]


def warmup() -> None:
    """Compile the kernels into the cache, for images and clusters, and print its path.

    This covers every method, contact forces, balls, the presets and motions. The kernels of other loss laws, and of
    spheroids, compile on first use.

    EULERDISK_CACHE_DIR sets another folder for the cache. The kernels are specific to the processor that compiles them.
    EULERDISK_NOTICES=no silences the notices about slow steps.
    """
    from sweep.engine.compute import problem_of_cuda
    from sweep.model.kernel import cache_root, check_cache

    tasks, kernels = usual_tasks()
    for name, seconds in perform(tasks):
        show(f"{name:<20} ready after {seconds:.1f} s")
    check_cache(kernels)
    problem = problem_of_cuda()
    show(f"device  {f'cpu only: {problem}' if problem else 'cpu, and cuda with device=cuda'}")
    show(f"cache  {cache_root()}")


def usual_tasks() -> "tuple[Tasks, list[Kernel]]":
    """Return tasks that compile the kernels of all methods, additions, presets and motions; and the runs' kernels."""
    from sweep.model import registry
    from sweep.motion.tables import kind_of_model
    from sweep.request.spec import SweepSpec
    from sweep.request.spec_file import presets
    from sweep.runs.forecast import coarse
    from sweep.runs.in_memory import run

    tasks: dict[str, Callable[[], object]] = {}
    kernels: list[Kernel] = []
    followed: list[str] = []
    for model in registry.every():
        # presets cover the other methods of bodies
        methods = model.methods_for(SweepSpec(model=model.name).words())
        specs = {method: SweepSpec(model=model.name, method=method) for method in methods}
        specs |= {word: SweepSpec(model=model.name, **dict([word.split("=")])) for word in model.additions}
        if "body" in model.options and "ball" in model.options["body"].choices:
            specs["ball"] = SweepSpec(model=model.name, body="ball")
        # a preset may need a variant of the kernels, whatever the duration
        short = {"duration": 1e-3, "criterion": "departure:5deg"}
        specs |= {name: coarse(SweepSpec.preset(name, **short), 1) for name in presets(model)}
        for name, spec in specs.items():
            needed = model.kernels(spec)
            if not set(needed) <= set(kernels):
                kernels += needed
                tasks[f"{model.name} {name}"] = partial(run, spec)
        if model.motion:
            modules = [module for module in kind_of_model(model).kernels if module not in followed]
            followed += modules
            tasks[f"{model.name} motion"] = partial(_compile_motions, modules)
    return tasks, kernels


def _compile_motions(modules: Sequence[str]) -> None:
    from sweep.model.kernel import Kernel

    for module in modules:
        Kernel(module, "trajectory").make_ready()


def perform(tasks: Tasks) -> Iterator[tuple[str, float]]:
    """Perform tasks with one process per processor; yield the name and the seconds of each task, in order."""
    if not tasks:
        return
    # spawn, not fork: a forked process would have the threads' locks without the threads
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(platforms.available_threads(), len(tasks)), mp_context=spawn) as pool:
        try:
            yield from zip(tasks, pool.map(_timed, tasks.values()), strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _timed(task: Callable[[], object]) -> float:
    began = time.perf_counter()
    task()
    return time.perf_counter() - began
