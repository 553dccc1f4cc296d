"""Entry points pass arguments to compiled code and refuse invalid ones in Python."""

import itertools
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from messages import refused

from kernels.native import entry as entry_module
from kernels.native import machine_code, workers
from kernels.native.entry import Argument, entry, parallel

CHUNK = 8


@entry(
    rows="float64[:, ::1], written",
    factor="float64",
    flag="boolean",
    whole="int32[::1]",
    cube="int64[:, :, ::1]",
)
def mixed(rows, factor, flag, whole, cube):
    """Use every type of argument and return numbers of both types."""
    total = 0
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            rows[i, j] = factor * rows[i, j] if flag else -rows[i, j]
    for i in range(whole.size):
        total += whole[i]
    for i in range(cube.shape[0]):
        total += cube[i, 1, 2]
    return total, factor, rows.shape[1]


@entry(number="float64")
def half(number):
    """Return one number."""
    return 0.5 * number


@parallel(
    CHUNK,
    lambda *_: (np.empty(CHUNK),),
    starts="float64[:, ::1]",
    found="float64[::1], written",
    taken="int64[::1], written",
    memory="float64[::1]",
)
def squares(start, stop, starts, found, taken, memory):
    """Square numbers through the memory of the thread and count how often each cell is processed."""
    for cell in range(start, stop):
        memory[cell - start] = starts[0, cell]
    for cell in range(start, stop):
        found[cell] = memory[cell - start] * memory[cell - start]
        taken[cell] += 1


@entry(numbers="float64[::1]")
def raising(numbers):
    """Raise an exception, as no kernel may."""
    if numbers[0] > 0.0:
        raise ValueError
    numbers[0] = 1.0


@pytest.fixture
def threads():
    """Return a function that sets the number of threads until the test ends."""
    yield workers.use
    workers.use(None)


def test_every_type_of_argument_arrives():
    """Numbers, flags and arrays of several types and dimensions arrive as in the Python function."""
    whole, cube = np.arange(4, dtype=np.int32), np.arange(24).reshape(2, 3, 4)
    for flag in (True, False):
        rows, expected = np.arange(6.0).reshape(2, 3), np.arange(6.0).reshape(2, 3)
        assert mixed(rows, 2.5, flag, whole, cube) == mixed.py_func(expected, 2.5, flag, whole, cube)
        np.testing.assert_array_equal(rows, expected)
    assert half(3.0) == 1.5


@pytest.mark.compiled
def test_an_array_of_another_type_is_refused():
    """Compiled code would read other memory than the array's."""
    other_types = [np.zeros((2, 3), np.float32), np.zeros((2, 3), np.int64), np.zeros(6)]
    for wrong in (*other_types, np.zeros((3, 2)).T, np.zeros((2, 6))[:, ::2]):
        with refused("rows", "float64", "2 dimensions", "C order", error=TypeError):
            mixed(wrong, 2.5, True, np.zeros(4, np.int32), np.zeros((2, 3, 4), np.int64))


@pytest.mark.compiled
def test_an_array_that_must_not_be_written_is_refused():
    """Compiled code would write to it anyway, or crash if the memory belongs to a file."""
    frozen = np.ones((2, 3))
    frozen.flags.writeable = False
    whole, cube = np.zeros(4, np.int32), np.zeros((2, 3, 4), np.int64)
    with refused("rows", "written", error=TypeError):
        mixed(frozen, 2.5, True, whole, cube)
    assert (frozen == 1.0).all()
    # a read-only array is allowed if it is only read
    whole.flags.writeable = False
    assert mixed(frozen.copy(), 2.5, True, whole, cube) == (0, 2.5, 3)


@pytest.mark.compiled
def test_an_array_that_is_not_aligned_is_refused():
    """Compiled code reads aligned memory; on some processors the process would crash."""
    shifted = np.zeros(49, np.uint8)[1:].view(np.float64).reshape(2, 3)
    assert not shifted.flags.aligned
    with refused("rows", "aligned", error=TypeError):
        mixed(shifted, 2.5, True, np.zeros(4, np.int32), np.zeros((2, 3, 4), np.int64))


@pytest.mark.compiled
def test_types_are_those_that_numba_writes():
    """Dimensions and element type of a signature text are those that Numba parses."""
    from numba import float64, int32, int64

    names = {"float64": float64, "int32": int32, "int64": int64}
    for text in ("float64", "float64[::1]", "int32[:, ::1]", "int64[:, :, ::1]"):
        assert Argument.of("a", text).numba_type() == eval(text, names)


def test_every_cell_is_treated_once(threads):
    """Every cell is processed once for any number of cells and threads, even more than processors or chunks."""
    for n, count in itertools.product((0, 1, CHUNK, CHUNK + 1, 10 * CHUNK - 1), (1, 2, 5)):
        threads(count)
        starts, found, taken = np.arange(1.0 * n)[None, :], np.full(n, -1.0), np.zeros(n, np.int64)
        squares(starts, found, taken)
        np.testing.assert_array_equal(found, starts[0] ** 2)
        assert (taken == 1).all(), (n, count)


def test_several_python_threads_may_call_at_once(threads):
    """Concurrent calls have their own chunks and memory, and each has its caller's number of threads."""
    n, used = 500 * CHUNK, []

    def call(results, factor):
        workers.use(2)
        used.append(workers.used())
        starts = factor * np.arange(1.0 * n)[None, :]
        for _ in range(5):
            squares(starts, results, np.zeros(n, np.int64))

    threads(1)
    all_results = [np.zeros(n) for _ in range(4)]
    callers = [threading.Thread(target=call, args=(each, 1.0 + i)) for i, each in enumerate(all_results)]
    for each in callers:
        each.start()
    for each in callers:
        each.join()
    for i, each in enumerate(all_results):
        np.testing.assert_array_equal(each, ((1.0 + i) * np.arange(1.0 * n)) ** 2)
    assert used == [2] * 4
    assert workers.used() == 1


@pytest.mark.compiled
def test_the_first_of_several_threads_compiles():
    """The other threads wait for the first one's result, because compiling takes seconds."""
    fresh, counted, together = half.copied(half.py_func), [], threading.Barrier(6)

    def source(entry_point):
        counted.append(1)
        time.sleep(0.05)
        return entry_point.compiled()

    def call(number):
        together.wait()
        return fresh(number)

    fresh.source = source
    with ThreadPoolExecutor(6) as pool:
        assert list(pool.map(call, range(6))) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    assert len(counted) == 1


def test_fewer_threads_than_asked_for_do_all_the_work(threads, monkeypatch):
    """If the system refuses a thread, the others process its cells."""

    def refuse(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    threads(3)
    n = 20 * CHUNK
    starts, found, taken = np.arange(1.0 * n)[None, :], np.full(n, -1.0), np.zeros(n, np.int64)
    squares(starts, found, taken)
    np.testing.assert_array_equal(found, starts[0] ** 2)
    assert (taken == 1).all()


def test_plain_python_treats_all_cells_in_one_thread(threads, monkeypatch):
    """Plain Python uses one thread, because several would only interrupt each other."""
    seen = set()

    def slowly(start, stop, starts, found, taken, memory):
        seen.add(threading.get_ident())
        time.sleep(0.001)
        squares.py_func(start, stop, starts, found, taken, memory)

    monkeypatch.setattr(entry_module, "PLAIN", True)
    monkeypatch.setattr(entry_module, "take", entry_module.take.py_func)
    threads(4)
    n = 20 * CHUNK
    starts, found, taken = np.arange(1.0 * n)[None, :], np.full(n, -1.0), np.zeros(n, np.int64)
    squares.copied(slowly)(starts, found, taken)
    assert (taken == 1).all()
    assert seen == {threading.get_ident()}


def test_a_failure_in_any_thread_is_told(threads):
    """An exception in any thread is raised in the caller."""
    threads(2)
    caller = threading.get_ident()

    def work():
        if threading.get_ident() != caller:
            raise MemoryError("no memory for a thread")

    with pytest.raises(MemoryError, match="no memory for a thread"):
        workers.run(work, 2)


@pytest.mark.compiled
def test_a_kernel_that_raises_is_told():
    """If a kernel raises, the call fails, so its incomplete results are not used."""
    numbers = np.array([-1.0])
    raising(numbers)
    assert numbers[0] == 1.0
    with pytest.raises(RuntimeError, match="raising raised an exception"):
        raising(numbers)


@entry(number="float64")
def positive(number):
    """Return a bool, which is not a 64-bit number."""
    return number > 0.0


@entry(numbers="int32[::1]")
def first(numbers):
    """Return a 32-bit number next to a 64-bit one."""
    return 1.0, numbers[0]


@pytest.mark.compiled
def test_a_result_that_cannot_be_read_is_refused_when_compiled():
    """A kernel whose result types cannot be read is refused and not cached."""
    for kernel, named in ((positive, "bool"), (first, "float64, int32")):
        with refused(kernel.__qualname__, named, error=TypeError):
            kernel.compiled()


@pytest.mark.compiled
def test_what_the_process_lacks_is_not_linked():
    """A symbol that the process lacks is refused, because LLVM would end the process."""
    made = machine_code.MachineCode("name", (), ("sin", "no_such_function"), b"")
    assert not made.is_lasting()
    assert made._replace(needed=("sin", "asinh")).is_lasting()
    with refused("no_such_function", error=RuntimeError):
        machine_code.load(made)


_CHILD = """
import os, sys, numpy as np
from kernels.native import workers
from sweep.model.kernel import Kernel
workers.use(2)
def run():
    starts = 0.5 + np.zeros((7, 9))
    Kernel("kernels.page.starts", "complete").load()(0, 4, starts)
    return starts[3, 0]
before = run()
child = os.fork()
if child == 0:
    os._exit(0 if run() == before else 1)
print(os.waitpid(child, 0)[1], "numba" in sys.modules, "llvmlite" in sys.modules)
"""


@pytest.mark.compiled
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_kept_code_needs_no_numba_and_works_after_a_fork():
    """A process with cached machine code does not import Numba, and a forked child can use the code."""
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", _CHILD],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.stdout.split() == ["0", "False", "True"], done.stderr
