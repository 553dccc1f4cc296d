"""Calls from compiled code to an entry point that is compiled apart from it, by its address."""

from kernels.native.function import PLAIN, LazyFunction

#: The address of no entry point.
NOWHERE = 0


def address_of(entry):
    """Return what compiled code calls an entry point by, of a `kernels.native.entry.Entry`; compiles or loads it.

    Where NUMBA_DISABLE_JIT is set nothing is compiled: the Python function takes the place of its address.
    """
    return entry.py_func if PLAIN else entry.address()


def caller_of(entry):
    """Return a function for kernels that calls an entry point: its arguments are the address and those of the entry.

    The entry point returns nothing. Arguments of other types than it declares are refused when the caller is compiled.
    """

    def by_address(address, *arguments):
        address(*arguments)

    return LazyFunction(by_address, lambda _, options: _compiled_caller(entry, options))


def _compiled_caller(entry, options):
    import numba
    from numba.core import cgutils, types
    from numba.core.errors import TypingError
    from numba.extending import intrinsic

    declared = tuple(each.numba_type() for each in entry.arguments)

    @intrinsic
    def call(typing_context, address, arguments):
        if tuple(arguments.types) != declared:
            raise TypingError(f"{entry.__qualname__} takes {declared}; got {arguments.types}.")

        def generate(context, builder, signature, values):
            function_type = context.call_conv.get_function_type(types.none, declared)
            function = builder.inttoptr(values[0], function_type.as_pointer())
            passed = cgutils.unpack_tuple(builder, values[1])
            context.call_conv.call_function(builder, function, types.none, declared, passed)
            return context.get_dummy_value()

        return types.none(types.int64, arguments), generate

    return numba.njit(**options)(lambda address, *arguments: call(address, arguments))
