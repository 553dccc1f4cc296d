"""Counting sort, and blocks of places with equal keys."""

from kernels.jit import kernel

#: Rows of the blocks of `blocks_of`: key of the block, its first place in `order`, the place after its last one.
KEY, FIRST, STOP = range(3)
BLOCK_ROWS = STOP + 1


@kernel
def counting_sort(keys, n, order, ends):
    """Order the first n places by their keys (counting sort: places with one key stay in turn).

    Parameters
    ----------
    keys : int64[:]
        Between 0 and the length of `ends`.
    n : int
        At least 1.
    order : int64[:], written
        The places, group after group.
    ends : int64[:], written between the least and the greatest key
        Where the group of each key ends in `order`; it begins where that of the key before ends.

    Returns
    -------
    least, greatest : int
        The least and the greatest key.
    """
    least = greatest = keys[0]
    for i in range(1, n):
        least, greatest = min(least, keys[i]), max(greatest, keys[i])
    for key in range(least, greatest + 1):
        ends[key] = 0
    for i in range(n):
        ends[keys[i]] += 1
    total = 0
    for key in range(least, greatest + 1):
        count = ends[key]
        ends[key] = total
        total += count
    for i in range(n):
        order[ends[keys[i]]] = i
        ends[keys[i]] += 1
    return least, greatest


@kernel
def blocks_of(keys, n, size, order, ends, blocks):
    """Order the first n places by their keys, in blocks of `size` at most that have one key each.

    Parameters
    ----------
    keys, n, order, ends
        As in `counting_sort`.
    size : int
    blocks : int64[BLOCK_ROWS, :], written
        Rows as above, one column per block.

    Returns
    -------
    int
        The number of blocks; at most n.
    """
    least, greatest = counting_sort(keys, n, order, ends)
    count = begin = 0
    for key in range(least, greatest + 1):
        for first in range(begin, ends[key], size):
            blocks[KEY, count], blocks[FIRST, count] = key, first
            blocks[STOP, count] = min(first + size, ends[key])
            count += 1
        begin = ends[key]
    return count
