"""What the parser of the command line refuses, said in the four parts of every other refusal."""

import difflib
import shlex
import sys
from collections.abc import Iterable
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from sweep.errors import RequestError

#: What the parser raises. typer brings its own copy of click or uses the one that is installed, and shows one class.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]

#: A word of the parser's message -> what the values of the option are.
_TAKES = {"integer": "a whole number", "float": "a number", "number": "a number"}


class Commands(TyperGroup):
    """The commands; one that is not there is refused with the nearest one that is."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the first word names."""
        if args and args[0] not in self.commands:
            raise RequestError(
                "unknown command",
                f"the commands are {', '.join(self.commands)}",
                args[0],
                _nearest(args[0], self.commands) or "use one of these; eulerdisk --help says what they do",
            )
        return super().resolve_command(ctx, args)


def refuse(error: Any) -> NoReturn:
    """Say what the parser found wrong, or end with the help where nothing was asked.

    Raises
    ------
    RequestError
    SystemExit
    """
    kind = type(error).__name__
    if kind == "NoArgsIsHelpError":
        error.show()
        sys.exit(error.exit_code)
    command = error.ctx.command_path if error.ctx else " ".join(["eulerdisk", *sys.argv[1:2]])
    param = getattr(error, "param", None)
    if kind == "NoSuchOption":
        raise _unknown_option(error, command)
    if kind == "MissingParameter" and param is not None:
        raise _missing(param, command)
    if param is not None and param.param_type_name == "option":
        raise _bad_value(param, command, error.message)
    raise RequestError(
        error.message.rstrip(".").lower(),
        " ".join(error.ctx.get_usage().split()[1:])
        if error.ctx
        else "an option has one value, and a switch has none",
        _words(),
        f"{command} --help says what it takes",
    )


def _unknown_option(error: Any, command: str) -> RequestError:
    options = [name for param in error.ctx.command.params for name in param.opts if name.startswith("-")]
    return RequestError(
        "unknown option",
        f"the options of {command} are {', '.join([*options, '--help'])}",
        error.option_name,
        _nearest(error.option_name, options) or f"leave it out; {command} --help says what they do",
    )


def _missing(param: Any, command: str) -> RequestError:
    written = _written(param)
    return RequestError(
        f"{written} is missing",
        f"{command} needs it: {param.help.rstrip('.')}",
        _words(),
        f"add {written}",
    )


def _bad_value(param: Any, command: str, message: str) -> RequestError:
    takes = next((text for word, text in _TAKES.items() if word in message), f"other values: {message}")
    return RequestError(
        "not a value of this option",
        f"{param.opts[0]} takes {takes}",
        _value_of(param.opts) or _words(),
        f"give one, or leave {param.opts[0]} out",
        param.opts[0],
    )


def _written(param: Any) -> str:
    """Return how a parameter is written: ``-o OUT.nc``, ``ATLAS.nc``."""
    shown = str(param.metavar or param.human_readable_name)
    if param.param_type_name == "option":
        return f"{min(param.opts, key=len)} {shown}"
    return shown.removesuffix("...")


def _value_of(names: Iterable[str]) -> str:
    """Return what the command line gives for an option."""
    for i, word in enumerate(sys.argv):
        for name in names:
            if word == name:
                return shlex.join(sys.argv[i : i + 2])
            if word.startswith(f"{name}="):
                return word
    return ""


def _words() -> str:
    return shlex.join(["eulerdisk", *sys.argv[1:]])


def _nearest(word: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean {close[0]}?" if close else ""
