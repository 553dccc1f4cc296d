"""Views of arrays that are not counted.

Numba counts the users of an array with atomic instructions at every call that passes one, unless it can prove the
pairs superfluous, which it cannot across loops and early returns. Small functions called a dozen times per cell spent
44 % of their time counting, and two threads counting the same array ran no faster than one (perf, two cores).
"""

from numba.extending import intrinsic, overload


def borrowed(array):
    """Return the same array without an owner: valid only as long as the caller keeps the array itself.

    Borrow what an argument brought: of an array that was made in the same function this may be the last use, and the
    compiler frees it then.
    """
    return array


@intrinsic
def _without_owner(typing_context, array):
    def generate(context, builder, signature, args):
        view = context.make_array(array)(context, builder, args[0])
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()

    return array(array), generate


@overload(borrowed)
def _borrowed(array):
    return lambda array: _without_owner(array)
