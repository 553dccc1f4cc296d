"""A measure of the processor: nothing but multiply-adds, as fast as it can do them."""

from kernels.jit import kernel

#: Multiply-adds of one number in one round, each of which waits for the one before.
LINKS = 16


@kernel
def multiply_add(numbers, rounds, a, b):
    """Replace every number x by a x + b, LINKS times in each round.

    The chains of neighbouring vectors overlap in the processor, so that all its units are busy.

    Parameters
    ----------
    numbers : float64[n], written
        Some hundred: they stay in the nearest cache, and hide the latency of a chain.
    rounds : int
    a, b : float
    """
    for _ in range(rounds):
        for k in range(numbers.size):
            x = numbers[k]
            for _ in range(LINKS):
                x = x * a + b
            numbers[k] = x
