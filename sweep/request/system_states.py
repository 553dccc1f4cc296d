"""The arguments of a body of revolution; states and parameters that every body has may be omitted."""

import ast
from collections.abc import Iterable

from sweep.errors import RequestError
from sweep.model.system.meridian import FALL_TILT
from sweep.request.system_source import Source
from sweep.request.system_units import alike, read_dimension, told

#: An argument and its default.
_Argument = tuple[ast.arg, ast.expr | None]

#: The states of every body, the states that a body has only if it names them, and the parameters of every body, with
#: units and defaults. If possible, the defaults are the same as for built-in bodies.
_ALWAYS = 'tilt: "rad" = "5 deg", tilt_rate: "rad/s" = 0.0, precession_rate: "rad/s" = 0.0, roll_rate: "rad/s" = 0.0'
_IF_NAMED = 'heading: "rad" = 0.0, roll_angle: "rad" = 0.0, contact_x: "m" = 0.0, contact_y: "m" = 0.0'
_PARAMETERS = f'radius: "m" = 0.5, gravity: "m/s2" = 9.81, {FALL_TILT}: "rad" = "85 deg"'


def with_states(source: Source, function: ast.FunctionDef) -> ast.FunctionDef:
    """Return the function of a body after adding the arguments that it omits.

    Raises
    ------
    RequestError
        If it names any other state, or gives one of these arguments another unit.
    """
    given = function.args
    if given.posonlyargs:
        # the reader of the signature refuses the mark /
        return function
    missing = [None] * (len(given.args) - len(given.defaults))
    states = _by_name(zip(given.args, (*missing, *given.defaults), strict=True))
    parameters = _by_name(zip(given.kwonlyargs, given.kw_defaults, strict=True))
    always, if_named, own = _read_arguments(_ALWAYS), _read_arguments(_IF_NAMED), _read_arguments(_PARAMETERS)
    for name, (argument, _) in states.items():
        if name not in always | if_named:
            source.refuse(
                argument.lineno,
                f"the states of a body are {', '.join(always | if_named)}; got {name} before the star",
                f"Write it after the star: def {function.name}(tilt, *, {name}=0.3).",
            )
    ours = always | {name: each for name, each in if_named.items() if name in states}
    front = [_merge_argument(source, function, each, states.get(name)) for name, each in ours.items()]
    behind = [each for name, each in parameters.items() if name not in own]
    behind += [_merge_argument(source, function, each, parameters.get(name)) for name, each in own.items()]
    arguments = ast.arguments(
        posonlyargs=given.posonlyargs, vararg=given.vararg, kwarg=given.kwarg,
        args=[each for each, _ in front], defaults=[each for _, each in front if each is not None],
        kwonlyargs=[each for each, _ in behind], kw_defaults=[each for _, each in behind],
    )  # fmt: skip
    whole = ast.FunctionDef(**{**dict(ast.iter_fields(function)), "args": arguments})
    return ast.copy_location(whole, function)


def _by_name(arguments: Iterable[_Argument]) -> dict[str, _Argument]:
    return {argument.arg: (argument, default) for argument, default in arguments}


def _read_arguments(text: str) -> dict[str, _Argument]:
    """Return the arguments in a text, by their names."""
    function = ast.parse(f"def body({text}): ...").body[0]
    assert isinstance(function, ast.FunctionDef)
    return _by_name(zip(function.args.args, function.args.defaults, strict=True))


def _merge_argument(
    source: Source, function: ast.FunctionDef, ours: _Argument, given: _Argument | None
) -> _Argument:
    """Return an argument of every body, with the unit and the default from a function if it gives them."""
    argument, default = ours
    assert isinstance(argument.annotation, ast.Constant)
    assert isinstance(default, ast.Constant)
    place, own = given if given is not None else (function, None)
    unit = getattr(place, "annotation", None) or argument.annotation
    if isinstance(unit, ast.Constant) and isinstance(unit.value, str):
        with source.at(place, f"the argument {argument.arg}"):
            wanted = read_dimension(str(argument.annotation.value))
            if not alike(read_dimension(unit.value), wanted):
                raise RequestError(f"it must be {told(wanted)}; got {unit.value}", hint="Leave its unit out.")
    merged = ast.copy_location(ast.arg(argument.arg, unit), place)
    return merged, own or ast.copy_location(ast.Constant(default.value), place)
