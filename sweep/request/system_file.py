"""Reading a system from a user's ``.py`` file, which is parsed and never executed.

A file contains imports, constants, and functions marked ``@system(...)``. Positional arguments are states, keyword-only
arguments are parameters, annotations are units, and the function returns the rate of each state.
"""

import ast
import dataclasses
import math
import re
from collections.abc import Mapping
from pathlib import Path

from sweep.errors import RequestError, shown
from sweep.model.quantity import DECISION, Quantity
from sweep.model.system.definition import FUNCTIONS, TIME, Declared, Definition, symbols
from sweep.model.system.meridian import FALL_TILT, check_body
from sweep.model.system.spelling import system_text
from sweep.request.spec_file import read_regular
from sweep.request.suggestions import suggestion
from sweep.request.system_body import Arithmetic, Body, check_start
from sweep.request.system_meridian import FELL, MEASURES, falls, read_motion
from sweep.request.system_source import MOST_BYTES, Source
from sweep.request.system_states import with_states
from sweep.request.system_tree import NUMBERS, Part, Tree, symbol
from sweep.request.system_units import PURE, SECOND, alike, check_scale, read_dimension, told, written
from sweep.request.system_words import MARKS, Words, check_name, check_variable
from sweep.request.units import number_and_unit
from sweep.request.values import read_number

#: Largest number of characters of a system's canonical text.
MOST_OF_TEXT = 16_000
#: Largest numbers of states and parameters.
_MOST_STATES, _MOST_PARAMETERS = 32, 64

#: Modules that a file may import: nothing is loaded, because their functions and numbers are known by name.
_MODULES = ("sweep.systems", "math", "numpy", "__future__")

#: Statements that are not allowed at the top level of a file -> their name, and a hint.
_NO_PLACE: Mapping[type[ast.stmt], tuple[str, str]] = {
    ast.For: ("a loop", "Write each system out."),
    ast.While: ("a loop", "Write each system out."),
    ast.If: ("a choice with if", "Remove it: the file is read, not executed."),
    ast.ClassDef: ("a class", "Write a function marked @system(...)."),
    ast.AsyncFunctionDef: ("the word async", "Write def."),
    ast.Expr: ("an expression", "Remove it: the file is read, not executed."),
    ast.AugAssign: ("an assignment with an operator", "Write name = number."),
    ast.AnnAssign: ("an annotation", "Write name = number; a number with a unit must be a parameter."),
}


def read_system(text: str, name: str = "", where: str = "") -> Definition:
    """Return a system of a file.

    Parameters
    ----------
    text : str
        Content of the file.
    name : str, optional
        The name of the system; optional if the file has only one.
    where : str, optional
        The name of the file in messages.

    Raises
    ------
    RequestError
        If the text is not a file of systems, or its system cannot be computed; with the line and a hint.
    """
    source = Source(text, where)
    functions, constants = _read_contents(source)
    return _read(source, _choose_function(functions, name, where), constants)


def _choose_function(functions: Mapping[str, ast.FunctionDef], name: str, where: str) -> ast.FunctionDef:
    """Return the system with a name, or the only one."""
    if not name and len(functions) > 1:
        raise RequestError(
            f"The file has {len(functions)} systems: {shown(', '.join(functions))}.",
            hint=f"Name one of them after a colon, as in mine.py:{next(iter(functions))}.",
            where=where or None,
        )
    found = functions.get(name) if name else next(iter(functions.values()), None)
    if found is None:
        known = f"it has {shown(', '.join(functions))}" if functions else "it has no systems at all"
        raise RequestError(
            f"The file has no system {shown(name)}; {known}." if name else "The file has no system.",
            hint=suggestion(name, tuple(functions))
            or 'A system is a function marked @system(duration="10 s").',
            where=where or None,
        )
    return found


def read_system_file(path: Path | str, name: str = "") -> Definition:
    """Return a system from the file at a path; see `read_system`.

    Raises
    ------
    RequestError
        As in `read_system`, and if the file cannot be read.
    """
    try:
        text = read_regular(Path(path), MOST_BYTES).decode("utf-8-sig")
    except OSError as problem:
        raise RequestError(
            f"The file cannot be read: {problem.strerror or type(problem).__name__}.",
            hint="Check the path; a file of systems is a short text file.",
            where=str(path),
        ) from problem
    # text that is not UTF-8, or a path with a zero byte
    except ValueError as problem:
        raise RequestError(
            f"The file is not text in UTF-8: {problem}.", hint="Save it as UTF-8.", where=str(path)
        ) from problem
    return read_system(text, name, str(path))


def system_names(text: str) -> tuple[str, ...]:
    """Return the names of the systems in a file, in their order.

    Raises
    ------
    RequestError
        If the text is not a file of systems.
    """
    return tuple(_read_contents(Source(text))[0])


def read_function(text: str, where: str, first: int, constants: Mapping[str, float]) -> Definition:
    """Return the system of one marked function, from the text of this function only.

    Parameters
    ----------
    text, where : str
        The text, and the name of its file in messages.
    first : int
        The line number of the function in the file.
    constants : mapping of str to float
        The numbers defined in its module.

    Raises
    ------
    RequestError
    """
    source = Source(text, where, first)
    functions, _ = _read_contents(source)
    return _read(source, _choose_function(functions, "", where), constants)


def _read_contents(source: Source) -> tuple[dict[str, ast.FunctionDef], dict[str, float]]:
    """Return the systems and the constants of a file."""
    functions: dict[str, ast.FunctionDef] = {}
    tree = Tree()
    for line in source.parsed().body:
        with source.at(line):
            match line:
                case ast.Import() | ast.ImportFrom():
                    _check_import(line)
                case ast.Expr(value=ast.Constant(value=str())):
                    pass
                case ast.Assign(targets=[ast.Name(id=name)]):
                    if name in (*FUNCTIONS, *NUMBERS, TIME, *MARKS):
                        raise RequestError(f"the name {name} is reserved", hint="Choose another name.")
                    tree.names[name] = tree.number(Arithmetic(source, tree).number(line.value))
                case ast.FunctionDef():
                    _check_decorator(line)
                    check_name(line.name, functions, (*FUNCTIONS, *NUMBERS, *MARKS))
                    functions[line.name] = line
                case _:
                    what, instead = _NO_PLACE.get(
                        type(line),
                        (
                            "this",
                            "A file contains imports, name = number, and functions marked @system(...).",
                        ),
                    )
                    raise RequestError(f"{what} is not allowed in a file of systems", hint=instead)
    return functions, {name: part.value or 0.0 for name, part in tree.names.items()}


def _check_import(line: ast.Import | ast.ImportFrom) -> None:
    modules = [line.module or "."] if isinstance(line, ast.ImportFrom) else [each.name for each in line.names]
    for module in modules:
        if module not in _MODULES:
            raise RequestError(
                f"the module {shown(module)} cannot be imported, because the file is read, not executed",
                hint="Write from sweep.systems import system, sin, cos, and define constants in the file itself.",
            )
    if isinstance(line, ast.ImportFrom) and any(each.asname for each in line.names):
        raise RequestError("an imported function cannot be renamed", hint="Remove as ...")


def _check_decorator(function: ast.FunctionDef) -> None:
    marks = function.decorator_list
    if len(marks) == 1 and isinstance(marks[0], ast.Call) and isinstance(marks[0].func, ast.Name):
        if marks[0].func.id in MARKS:
            return
    elif len(marks) == 1 and isinstance(marks[0], ast.Name) and marks[0].id in MARKS:
        example = _example_duration(function, marks[0].id)
        raise RequestError("the duration is missing", hint=f'Write @{marks[0].id}(duration="{example}").')
    raise RequestError(
        f"the function {shown(function.name)} must have one decorator, @system(...)",
        hint=f'Write @system(duration="{_example_duration(function, "system")}") above it, or remove it.',
    )


def _example_duration(function: ast.FunctionDef, mark: str) -> str:
    """Return an example of a duration with the units of a function's arguments; bodies always have units."""
    arguments = (*function.args.args, *function.args.kwonlyargs)
    return "10 s" if mark == "body" or any(each.annotation for each in arguments) else "10"


def _read(source: Source, function: ast.FunctionDef, constants: Mapping[str, float]) -> Definition:
    """Return the system of a marked function."""
    call = function.decorator_list[0]
    assert isinstance(call, ast.Call)
    assert isinstance(call.func, ast.Name)
    mark = call.func.id
    words = Words(source, mark, call, constants, _example_duration(function, mark))
    duration, time_units = words.duration()
    tree = Tree()
    tree.names = {name: tree.number(value) for name, value in constants.items()}
    whole = function if mark == "system" else with_states(source, function)
    states, parameters, arguments = _read_signature(source, whole, tree, time_units)
    time = symbol(TIME, SECOND if time_units == "s" else PURE)
    words.prepare(arguments, states, time)
    tree.names |= arguments
    if any(each.arg == TIME for each in function.args.kwonlyargs):
        tree.names[TIME] = time
    fixed = frozenset({*arguments, TIME, *FUNCTIONS, *NUMBERS})
    motion = None
    if mark == "system":
        rates = Body(source, tree, states, fixed).read(function, time_units)
    else:
        motion = read_motion(source, tree, function, states, parameters, fixed)
        rates = motion.rates
        if fall := falls(motion, words.ends(), parameters):
            words.add("ends", {FELL: fall})
        words.add("measures", MEASURES)
    check_start(source, tree, (*states, *parameters), rates)
    ends, measures = words.ends(), words.measures()
    labels = words.labels(ends)
    found = Definition(
        function.name, _read_title(source, function), states, parameters, time_units, duration, rates, ends, measures,
        labels, (motion.energy,) if motion else words.conserved(),
        words.stable(states, parameters, measures, ends, labels, time_units), words.theory(parameters),
        motion.meridian if motion else None,
    )  # fmt: skip
    if motion:
        found = _check_body_rolls(source, function, found)
    _check_used(source, function, found)
    text = system_text(found)
    if len(text) > MOST_OF_TEXT:
        source.refuse(
            function.lineno,
            f"a system has at most {MOST_OF_TEXT} characters with all its numbers written out; got {len(text)}",
            "Write a smaller system.",
        )
    return dataclasses.replace(found, text=text)


def _check_body_rolls(source: Source, function: ast.FunctionDef, found: Definition) -> Definition:
    """Return a body after checking that it can roll with its default values; drop the fall tilt if it is not used."""
    with source.at(function.body[-1], "the body"):
        check_body(found, {each.name: each.default for each in (*found.states, *found.parameters)})
    named = {each.arg for each in function.args.kwonlyargs}
    used = {name for end in found.ends for node in end.any_positive for name in symbols(node)}
    kept = tuple(each for each in found.parameters if each.name != FALL_TILT or each.name in named | used)
    return dataclasses.replace(found, parameters=kept)


def _read_title(source: Source, function: ast.FunctionDef) -> str:
    text = ast.get_docstring(function) or ""
    title = text.strip().split("\n")[0].strip()
    if not title.isprintable() or len(title) > 200:
        source.refuse(
            function.body[0].lineno,
            "a title is one line of at most 200 printable characters",
            "Write a shorter title.",
        )
    return title


def _check_used(source: Source, function: ast.FunctionDef, found: Definition) -> None:
    """Refuse a parameter that has no effect: it is probably misspelled somewhere, or left over."""
    nodes = [
        *found.rates,
        *(node for end in found.ends for node in end.any_positive),
        *(node for label in found.labels for node in label.all_positive),
        *(node for measure in found.measures for node in measure.expressions),
        *(node for measure in found.measures if measure.moment for node in measure.moment.expressions),
        *found.conserved,
        *(node for _, node in found.theory),
    ]
    used = {name for node in nodes for name in symbols(node)} | {*re.findall(r"\w+", found.stable)}
    for each in function.args.kwonlyargs:
        if each.arg not in used and each.arg != TIME:
            source.refuse(each.lineno, f"the parameter {each.arg} is not used", "Remove it, or use it.")


def _read_signature(
    source: Source, function: ast.FunctionDef, tree: Tree, time_units: str
) -> tuple[tuple[Declared, ...], tuple[Declared, ...], dict[str, Part]]:
    """Return the states, the parameters, and the expression of each name."""
    given = function.args
    with source.at(function):
        if given.vararg or given.kwarg:
            raise RequestError(
                "*args and **kwargs are not allowed",
                hint="Name every state and every parameter.",
            )
        if given.posonlyargs:
            raise RequestError("the mark / is not allowed here", hint="Remove it.")
        if not given.args:
            raise RequestError(
                "a system must have at least one state", hint="Write def name(x=0.0, *, damping=0.1)."
            )
        if len(given.args) > _MOST_STATES or len(given.kwonlyargs) > _MOST_PARAMETERS:
            raise RequestError(
                f"a system has at most {_MOST_STATES} states and {_MOST_PARAMETERS} parameters; got "
                f"{len(given.args)} and {len(given.kwonlyargs)}",
                hint="Write a smaller system.",
            )
    found: dict[str, tuple[Declared, Part]] = {}
    missing = [None] * (len(given.args) - len(given.defaults))
    defaults = (*missing, *given.defaults, *given.kw_defaults)
    for argument, default in zip((*given.args, *given.kwonlyargs), defaults, strict=True):
        with source.at(argument, f"the argument {argument.arg}"):
            if argument.arg == TIME:
                _check_time(argument, default, argument in given.kwonlyargs, time_units)
                continue
            check_variable(argument.arg, found)
            found[argument.arg] = _read_argument(source, argument, default, tree)
    declared = tuple(each for each, _ in found.values())
    count = len(given.args)
    return declared[:count], declared[count:], {name: part for name, (_, part) in found.items()}


def _read_argument(
    source: Source, argument: ast.arg, default: ast.expr | None, tree: Tree
) -> tuple[Declared, Part]:
    unit = _read_unit(argument)
    dimension = read_dimension(unit)
    units = written(dimension)
    if units is None:
        raise RequestError(
            f"the unit {shown(unit)!r} has too large a power", hint="Write a unit such as m/s2."
        )
    if default is None:
        raise RequestError("it has no default", hint=f"Write one, as in {argument.arg}=1.0.")
    with source.at(default, f"the argument {argument.arg}"):
        quantity = Quantity(argument.arg, "", units, "", DECISION)
        if isinstance(default, ast.Constant) and isinstance(default.value, str):
            pair = number_and_unit(default.value)
            if pair is None or not {":", ","}.isdisjoint(default.value):
                written_so = f'{argument.arg}: "{unit}" = 0.5' if unit else f"{argument.arg}=0.5"
                raise RequestError(
                    f"its default must be one number; got {shown(default.value)}", hint=f"Write {written_so}."
                )
            check_scale(default.value)
            if pair is not None and not pair[1] and unit:
                raise RequestError(
                    "a number in quotes needs a unit", hint=f'Write {argument.arg}="{pair[0]} {unit}".'
                )
            if pair is not None and pair[1] and not unit:
                raise RequestError(
                    "its default has a unit, but it has no annotation with its unit",
                    hint=f'Write {argument.arg}: "{pair[1]}" = {pair[0]}.',
                )
            value = read_number(default.value, quantity)
        else:
            number = Arithmetic(source, Tree(names=dict(tree.names))).number(default)
            value = read_number(f"{number!r} {unit}" if unit not in ("", "1") else number, quantity)
    return Declared(argument.arg, units, value), symbol(argument.arg, dimension)


def _read_unit(argument: ast.arg) -> str:
    if argument.annotation is None:
        return ""
    if isinstance(argument.annotation, ast.Constant) and isinstance(argument.annotation.value, str):
        return " ".join(argument.annotation.value.split())
    raise RequestError(
        "an annotation must be a unit in quotes", hint=f'Write {argument.arg}: "m", or remove it.'
    )


def _check_time(argument: ast.arg, default: ast.expr | None, behind: bool, time_units: str) -> None:
    """Refuse the time unless it is a keyword-only argument without a default."""
    if not behind:
        raise RequestError(
            "t is the time, which is not a state",
            hint="Write it as the last keyword-only argument: *, t.",
        )
    if default is not None:
        raise RequestError("the time must not have a default: it begins at 0", hint="Write only t.")
    wanted = SECOND if time_units == "s" else PURE
    given = read_dimension(_read_unit(argument))
    if argument.annotation is not None and not alike(given, wanted):
        raise RequestError(
            f"the time must be {told(wanted)}, like the duration", hint='Write only t, and duration="10 s".'
        )


def is_number(value: object) -> bool:
    """Return whether a Python value is a finite number, which a system may use as a constant."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
