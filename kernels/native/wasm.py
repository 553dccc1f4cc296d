"""Compilation of entry points to WebAssembly, for a page: only with LLVM, without a linker and without a C library.

Numba writes LLVM IR for the processor of this machine. Here it is compiled for wasm32 instead, with vectors of 128
bits and no instruction whose result depends on the machine. Three points need care:

Layout
    Pointers have half their width. No LLVM pass may run on a function before it has the layout of wasm32: otherwise
    its offsets in bytes are those of this processor, and it silently computes wrong results. So a process that makes
    WebAssembly makes nothing else (`begin`).

Linking
    A single object needs no linker: its provisional addresses are valid if its data begin at address 0. It imports
    its memory, its function table and its stack pointer. Only exports are missing; `exporting` adds them.

The C library
    Kernels replace its functions (`kernels.page.c_library`), under the names that Numba calls.
"""

import json
import re

from llvmlite import binding

from kernels.native import compiler
from kernels.native.function import lazy

#: Address at which the stack begins; it grows down to the data of the module. The page's own memory begins here too.
STACK = 1 << 18

_LEAST_STACK = 1 << 17

#: Name of the section that describes how to call the entry points.
NOTE = "eulerdisk"

_TRIPLE = "wasm32-unknown-unknown"

#: Vectors, and copies of memory without function calls; no relaxed instructions, whose results depend on the machine.
_FEATURES = "+simd128,+bulk-memory,+sign-ext,+mutable-globals,+nontrapping-fptoint"

#: Parts of LLVM IR that refer to the processor for which it was written.
_HOST = re.compile(r"^target (?:triple|datalayout) = .*\n", re.MULTILINE)
_PROCESSOR = re.compile(r'"(?:target-cpu|target-features|tune-cpu|prefer-vector-width)"="[^"]*"')

#: Functions of the C library, including those that LLVM calls for its intrinsics. Under these names LLVM would
#: transform them, and evaluate some at compile time with the library of this machine.
_C_FUNCTION = re.compile(
    r"@(?:llvm\.)?(a?(?:sin|cos|tan)h?|atan2|exp2?|expm1|log(?:2|10|1p)?|pow|hypot)(?:\.f64)?\("
)

#: Exceptions that Numba would raise if one of its operations failed. No kernel raises, and they contain local paths.
_RAISED = re.compile(r'^@"?\.const\.pickle.*\n', re.MULTILINE)
_USE_OF_RAISED = re.compile(r'@"?\.const\.picklebuf\.[\w.]+"?')

_CUSTOM, _EXPORT, _ELEMENTS, _DATA = 0, 7, 9, 11


def begin():
    """Disable all LLVM passes on IR that Numba writes from now on; to be called before any kernel is compiled."""

    def nothing(*_):
        """Optimise nothing."""

    def complete(library):
        """Link nothing either: `module` links each function once, instead of into each of its callers."""
        library._finalized = True

    compiler._PartLibrary._optimize_functions = nothing
    compiler._PartLibrary.finalize = complete


def module(entries, c_library, more):
    """Return the bytes of a WebAssembly module; `begin` must have been called.

    Its section NOTE contains JSON: ``entries``, the arguments (as in `kernels.native.entry.Argument`) and results of
    each entry point, and `more`.

    Parameters
    ----------
    entries : mapping of str to kernels.native.entry.Entry
        Name of an exported function -> the entry point.
    c_library : mapping of str to kernels.native.function.LazyFunction
        Name of a function of the C library -> its replacement, a function of numbers.
    more : mapping
        Content that can be written as JSON.

    Raises
    ------
    ValueError
        If a called function is missing, or the data leave too little room for the stack.
    """
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    target = binding.Target.from_triple(_TRIPLE)
    machine = target.create_target_machine(opt=3, features=_FEATURES, reloc="static")
    head = f'target datalayout = "{machine.target_data}"\ntarget triple = "{_TRIPLE}"\n'
    whole, listed, linked = binding.parse_assembly(head), {}, set()

    def link(text):
        whole.link_in(binding.parse_assembly(head + text))

    for name, entry in entries.items():
        made, results, parts = _language(lazy()(entry._called()), entry._numba_types(), linked)
        listed[name] = {"arguments": [each[:3] for each in entry.arguments], "results": results}
        for text in parts:
            link(text.replace(f"@{made}(", f"@{name}("))
    # such a function may call others
    while called := [name for name in _outside(whole) if name.removeprefix("c_") in c_library]:
        for name in called:
            for text in _c_function(name, c_library[name.removeprefix("c_")], linked):
                link(text)
    _optimise(whole, machine, entries)
    if missing := [name for name in _outside(whole) if not name.startswith("llvm.")]:
        raise ValueError(f"This module has no function {', '.join(missing)}.")
    note = json.dumps({"entries": listed, **more}, separators=(",", ":"))
    return exporting(machine.emit_object(whole), entries) + _section(_CUSTOM, _text(NOTE) + note.encode())


def _outside(whole):
    """Return the names of the functions that a module calls but does not contain."""
    return [each.name for each in whole.functions if each.is_declaration]


def _language(function, types, linked):
    """Return the name of the function that Numba makes from a `LazyFunction`, the types of its results, and its parts.

    Each part is the IR of the function, or of a callee that is not in `linked`; its library is added to this set.
    """
    from numba.core.compiler_lock import global_compiler_lock

    with global_compiler_lock, compiler.without_collecting():
        function.compiled.compile(types)
        made = function.compiled.overloads[types]
        parts = [_as_text(each._final_module) for each in _libraries(made.library, linked)]
    return made.fndesc.llvm_func_name, compiler.results_of(made.signature), parts


def _libraries(library, linked):
    """Yield a Numba library and the libraries that it calls, each once; libraries of other code are linked already."""
    if library not in linked:
        linked.add(library)
        library._ensure_finalized()
        yield library
        for each in library._linking_libraries if isinstance(library, compiler._PartLibrary) else ():
            yield from _libraries(each, linked)


def _as_text(module):
    """Return a module as LLVM IR for no particular processor, with C functions renamed to names unknown to LLVM."""
    text = _HOST.sub("", _PROCESSOR.sub('"of-a-kernel"', str(module)))
    text = _USE_OF_RAISED.sub("null", _RAISED.sub("", text))
    text = _C_FUNCTION.sub(r"@c_\1(", text).replace("@sqrt(", "@llvm.sqrt.f64(")
    # variables that Numba shares between modules become internal to each module, because names are not unique
    return re.sub(
        r"= (?:common|weak_odr|weak|linkonce_odr) ((?:\w+ )*(?:global|constant) )", r"= internal \1", text
    )


def _c_function(name, function, linked):
    """Return the parts of a function as called by C, and as called by Numba: storing its result, returning a status."""
    from numba import types

    numbers = function.py_func.__code__.co_argcount
    made, _, parts = _language(function, numbers * (types.float64,), linked)
    given = ", ".join(f"double %x{i}" for i in range(numbers))
    declared = f"declare i32 @{made}(ptr, ptr, {', '.join(numbers * ['double'])})"
    return [
        *parts,
        f"{declared}\ndefine double @{name}({given}) alwaysinline {{\n  %result = alloca double\n"
        f"  %status = call i32 @{made}(ptr %result, ptr null, {given})\n"
        "  %found = load double, ptr %result\n  ret double %found\n}\n",
    ]


def _optimise(whole, machine, exported):
    """Keep the exported functions and their dependencies, and optimise them for layout and vectors of wasm32."""
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration and each.name not in exported:
            each.linkage = "internal"
    whole.verify()
    tuning = binding.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    builder = binding.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(whole, builder)


def exporting(content, names):
    """Return a WebAssembly object as a module that exports functions, without its symbols, which are not needed.

    Parameters
    ----------
    content : bytes
    names : sequence of str

    Raises
    ------
    ValueError
        If its data leave too little room for the stack.
    """
    sections = list(_sections(content))
    places = {}
    for number, body in sections:
        if number == _CUSTOM and body[1:8] == b"linking":
            places |= _functions_in(body)
        elif number == _DATA and len(body) > STACK - _LEAST_STACK:
            raise ValueError(
                f"The data have {len(body)} bytes, at most {STACK - _LEAST_STACK} leave room for a stack."
            )
    listed = [_text(name) + b"\0" + _number(places[name]) for name in names]
    export = _EXPORT, _number(len(names)) + b"".join(listed)
    kept = [each for each in sections if each[0] != _CUSTOM]
    at = next(i for i, (number, _) in enumerate(kept) if _EXPORT < number)
    return content[:8] + b"".join(_section(*each) for each in [*kept[:at], export, *kept[at:]])


def _section(number, body):
    return bytes([number]) + _number(len(body)) + body


def _text(name):
    return _number(len(name)) + name.encode()


def _sections(content):
    """Yield the number and the content of each section."""
    at = 8
    while at < len(content):
        size, begin_at = _read(content, at + 1)
        yield content[at], content[begin_at : begin_at + size]
        at = begin_at + size


def _functions_in(body):
    """Return a mapping from the name of each function to its index, from the symbol table in the section ``linking``.

    According to the WebAssembly tool conventions (Linking.md), the kinds of symbols are function 0, data 1, global 2,
    section 3, event 4, table 5. The flag 0x10 marks a symbol as undefined, 0x40 as having a name nevertheless.
    """
    found, at = {}, 9
    while at < len(body):
        kind = body[at]
        size, at = _read(body, at + 1)
        end = at + size
        count, at = _read(body, at) if kind == 8 else (0, at)
        for _ in range(count):
            what, (flags, at) = body[at], _read(body, at + 1)
            if what == 3:
                _, at = _read(body, at)
                continue
            if what != 1:
                place, at = _read(body, at)
            if what == 1 or not flags & 0x10 or flags & 0x40:
                length, at = _read(body, at)
                name, at = body[at : at + length].decode(), at + length
                if what == 0:
                    found[name] = place
            if what == 1 and not flags & 0x10:
                for _ in range(3):
                    _, at = _read(body, at)
        at = end
    return found


def _read(content, at):
    """Return a number (unsigned LEB128) and the position after it."""
    found = shift = 0
    while True:
        byte = content[at]
        at, found, shift = at + 1, found | (byte & 127) << shift, shift + 7
        if byte < 128:
            return found, at


def _number(value):
    """Return a number as unsigned LEB128."""
    found = b""
    while value > 127:
        found, value = found + bytes([value & 127 | 128]), value >> 7
    return found + bytes([value])
