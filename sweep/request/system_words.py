"""The words of ``@system(...)``: duration, endings, measures, labels, conserved quantities, stability and theory."""

import ast
import keyword
import re
from collections.abc import Callable, Collection, Mapping
from functools import lru_cache
from typing import Any, TypeVar

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.quantity import DECISION, Quantity, table
from sweep.model.system.definition import FUNCTIONS, TIME, Declared, Event, Label, Measure, Node, symbols
from sweep.model.system.tables import NO_LABEL, OWN_ENDINGS
from sweep.request.expression_text import read_expression
from sweep.request.start_list import WORDS as LIST_WORDS
from sweep.request.suggestions import suggestion
from sweep.request.system_body import Arithmetic, is_collection
from sweep.request.system_source import Source
from sweep.request.system_text import read_conserved, read_ending, read_label, read_measure, read_theory
from sweep.request.system_tree import NUMBERS, Part, Tree
from sweep.request.units import number_and_unit
from sweep.request.values import read_number
from sweep.request.words import options

#: The words, in the order of the system's canonical text.
WORDS = ("duration", "ends", "measures", "label", "conserved", "stable", "theory")

#: The words of a body; its conserved quantity is always the energy.
WORDS_OF_BODY = tuple(word for word in WORDS if word != "conserved")

#: Decorator -> its words.
MARKS: Mapping[str, tuple[str, ...]] = {"system": WORDS, "body": WORDS_OF_BODY}

#: The value of ``stable`` for motions that are stable if they do not end.
RUNS_ON = "runs on"

#: Names that atlases and requests use for other things, including attributes of a spec in Python.
_OTHERS = (
    "axes", "boundary", "boundary_width", "canonical", "cell", "computed", "conserved_change", "constants",
    "criterion", "device", "elapsed_time", "end_time", "ending", "error", "fingerprint", "fixed", "from",
    "from_canonical", "from_toml", "from_words", "headline", "interval", "is_list", "label", "listed", "method",
    "model", "name", "output", "preset", "quantities", "read", "replace", "resolve", "sensitive_from", "shape",
    "requested", "size", "stability", "stable", "status", "steps", "system", "threads", "time", "title", "to_toml",
    "short_title", "undecided", "unproved", "verdict", "words",
)  # fmt: skip
#: Global attributes and dimensions of an atlas, except those from the words of a request
#: (`tests/request/test_system_names.py` compares them with a written atlas).
_WRITTEN = (
    "Conventions", "citation", "criterion_meaning", "curve", "date_created", "history", "kernel_hash", "keywords",
    "license", "references", "requested_as", "software", "source", "start", "summary", "sweep_fingerprint",
    "sweep_spec", "versions",
)  # fmt: skip

#: Prefixes and suffixes of the names that an atlas derives from axes, states and measures.
_BEGUN, _MADE = ("boundary_", "predicted_", "critical_", "curve_", "eulerdisk_"), ("_end", "_error", "_units")

#: Word -> the name of one of its entries in messages.
_CALLED = {"ends": "ending", "measures": "measure", "label": "label", "theory": "theory of"}

#: Largest number of endings, of labels and of measures.
_MOST = 30
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_Made = TypeVar("_Made")


@lru_cache
def reserved() -> frozenset[str]:
    """Return the names that states, parameters and measures must not have: words of a request, functions, numbers."""
    disk = registry.named(registry.DEFAULT)
    of_requests = {*options(disk), *LIST_WORDS} - {*disk.options}
    fixed = ("duration", "step", "tolerance", TIME, "abs")
    return frozenset({*of_requests, *fixed, *_OTHERS, *_WRITTEN, *FUNCTIONS, *NUMBERS})


def check_name(name: str, taken: Collection[str] = (), beside: Collection[str] = ()) -> None:
    """Refuse a name that an atlas cannot have.

    Parameters
    ----------
    name : str
    taken : collection of str
        Names that are already taken.
    beside : collection of str
        Names with another meaning.

    Raises
    ------
    RequestError
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise RequestError(
            f"the name {shown(name)!r} is not allowed: a name has at most 40 letters from a to z, digits and _, and "
            "begins with a letter",
            hint="Write, for instance, theta for the Greek letter, or very_long for two words.",
        )
    if name in beside:
        kind = (
            "a function or a number" if name in (*FUNCTIONS, *NUMBERS) else "a word of requests and atlases"
        )
        raise RequestError(f"the name {name} is {kind}", hint=f"Choose another name, such as my_{name}.")
    if name in taken:
        raise RequestError(f"the name {name} is used twice", hint="Give each its own name.")


def check_variable(name: str, taken: Collection[str]) -> None:
    """Refuse a name that a variable or a parameter of an atlas cannot have.

    Raises
    ------
    RequestError
    """
    check_name(name, taken, reserved())
    if name.endswith(_MADE):
        raise RequestError(
            f"the name {name} has a suffix that is reserved for variables of an atlas ({', '.join(_MADE)})",
            hint="Choose another name.",
        )
    if name.startswith(_BEGUN):
        raise RequestError(
            f"the name {name} has a prefix that is reserved for variables of an atlas ({', '.join(_BEGUN)})",
            hint="Choose another name.",
        )


class Words:
    """The words of a decorator.

    Parameters
    ----------
    source : Source
    mark : str
        One of `MARKS`.
    call : ast.Call
    constants : mapping of str to float
        Numbers that its texts may name, in addition to the arguments of the function.
    example : str
        A duration that fits the units of the arguments: ``10 s``, or ``10`` for pure numbers.

    Raises
    ------
    RequestError
        With the line.
    """

    def __init__(
        self, source: Source, mark: str, call: ast.Call, constants: Mapping[str, float], example: str
    ) -> None:
        self._source, self._mark, self._line = source, mark, call
        self._example = f'duration="{example}"'
        self._tree = Tree(bare=True)
        self._constants = {name: self._tree.number(value) for name, value in constants.items()}
        self._names: tuple[str, ...] = ()
        self._given: dict[str, ast.expr] = {}
        if call.args:
            source.refuse(
                call.args[0].lineno, f"the words of {mark}(...) must have names", f"Write {self._example}."
            )
        for each in call.keywords:
            if each.arg not in MARKS[mark]:
                source.refuse(
                    each.value.lineno,
                    f"the word {shown(each.arg or '**')} is unknown to {mark}(...); its words are "
                    f"{', '.join(MARKS[mark])}",
                    suggestion(each.arg, MARKS[mark]) or "Use one of these words.",
                )
            self._given[each.arg] = each.value

    def duration(self) -> tuple[float, str]:
        """Return the duration of a motion, and the unit of the time."""
        node = self._given.get("duration")
        if node is None:
            self._source.refuse(
                self._line.lineno, "the duration is missing", f"Write @{self._mark}({self._example})."
            )
        with self._source.at(node, "the duration"):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                pair = number_and_unit(node.value)
                if pair is None:
                    raise RequestError(
                        f"it must be one time; got {shown(node.value)}", hint=f"Write {self._example}."
                    )
                units = "s" if pair is not None and pair[1] else "1"
                value = read_number(node.value, Quantity("duration", "", units, "", DECISION))
            elif is_collection(node):
                raise RequestError("it must be one time", hint=f"Write {self._example}.")
            else:
                tree = Tree(names=dict(self._constants))
                value, units = Arithmetic(self._source, tree).number(node), "1"
            if value <= 0.0:
                raise RequestError(f"it must be above 0; got {value:g}", hint=f"Write {self._example}.")
            if self._mark == "body" and units != "s":
                raise RequestError(
                    f"it must be a time with a unit; got {value:g}", hint=f"Write {self._example}."
                )
        return value, units

    def prepare(self, arguments: Mapping[str, Part], states: tuple[Declared, ...], time: Part) -> None:
        """Set the names that the texts may use."""
        self._names = tuple(each.name for each in states)
        self._tree.names |= self._constants | dict(arguments) | {TIME: time}

    def add(self, word: str, texts: Mapping[str, str]) -> None:
        """Add entries to a word, except those whose names it already has."""
        node = self._given.get(word) or ast.copy_location(ast.Dict([], []), self._line)
        if not isinstance(node, ast.Dict):
            # `_table` refuses it
            return
        known = {each.value for each in node.keys if isinstance(each, ast.Constant)}
        row = {name: text for name, text in texts.items() if name not in known}
        keys, values = (
            [ast.copy_location(ast.Constant(each), node) for each in given] for given in (row, row.values())
        )
        self._given[word] = ast.copy_location(ast.Dict([*node.keys, *keys], [*node.values, *values]), node)

    def ends(self) -> tuple[Event, ...]:
        """Return the endings."""
        return self._table("ends", lambda name, text: Event(name, read_ending(text, self._tree, self._names)))

    def measures(self) -> tuple[Measure, ...]:
        """Return the measures."""

        def measure(name: str, text: str) -> Measure:
            check_variable(name, tuple(self._tree.names))
            return read_measure(name, text, self._tree, self._names)

        return self._table("measures", measure)

    def labels(self, ends: tuple[Event, ...]) -> tuple[Label, ...]:
        """Return the labels; refuse a label with the name of an ending."""
        taken = tuple(each.name for each in ends)
        rest: list[str] = []

        def label(name: str, text: str | None) -> Label:
            check_name(name, taken)
            if rest:
                raise RequestError(
                    f"it can never match: {rest[0]} (True) comes before it", hint="Write True last."
                )
            if text is None:
                rest.append(name)
                return Label(name, ())
            return Label(name, read_label(text, self._tree, self._names))

        return self._table("label", label, "Write the condition in quotes, or True for the last label.")

    def conserved(self) -> tuple[Node, ...]:
        """Return the conserved quantities."""
        node = self._given.get("conserved")
        if node is None:
            return ()
        if isinstance(node, ast.Dict | ast.Set):
            self._source.refuse(
                node.lineno,
                "conserved takes an expression or a list of expressions, without names",
                'Write conserved="..." or conserved=["...", "..."].',
            )
        nodes = node.elts if isinstance(node, ast.List | ast.Tuple) else [node]
        found = []
        for each in nodes:
            with self._source.at(each, "the conserved quantity"):
                found.append(read_conserved(_text(each), self._tree, self._names))
        return tuple(found)

    def theory(self, parameters: tuple[Declared, ...]) -> tuple[tuple[str, Node], ...]:
        """Return the expressions for the boundary along parameters and states, from theory."""
        allowed = (*self._names, *(each.name for each in parameters))

        def row(name: str, text: str) -> tuple[str, Node]:
            if name not in allowed:
                raise RequestError(
                    f"the name {shown(name)} is not a parameter or a state; the names are {', '.join(allowed)}",
                    hint=suggestion(name, allowed) or "Use one of these names.",
                )
            node = read_theory(text, self._tree, self._tree.names[name])
            if beside := {name, TIME} & set(symbols(node)):
                raise RequestError(
                    f"the expression may not contain {name} or {TIME}; got {', '.join(sorted(beside))}",
                    hint=f"Solve it for {name}.",
                )
            return name, node

        return self._table("theory", row, example=parameters[0].name if parameters else self._names[0])

    def stable(
        self,
        states: tuple[Declared, ...],
        parameters: tuple[Declared, ...],
        measures: tuple[Measure, ...],
        ends: tuple[Event, ...],
        labels: tuple[Label, ...],
        time_units: str,
    ) -> str:
        """Return the condition of stability in canonical spelling; a criterion may name the variables of a cell."""
        node = self._given.get("stable")
        if node is None:
            return ""
        with self._source.at(node, "the condition stable"):
            text = _text(node, f'Write stable="{RUNS_ON}", or a criterion in quotes.').strip()
            if text == RUNS_ON:
                return text
            flags = {
                "ending": (*OWN_ENDINGS, *(each.name for each in ends)),
                "label": (NO_LABEL, *(each.name for each in labels)),
            }
            units = {each.name: each.units for each in (*states, *parameters)}
            units |= {each.name: each.units for each in measures} | {"end_time": time_units}
            units |= {f"{each.name}_end": each.units for each in states}
            quantities = [
                *(Quantity(name, "", unit, "", DECISION) for name, unit in units.items()),
                *(
                    Quantity(name, "", "1", "", DECISION, flags=dict(enumerate(codes)))
                    for name, codes in flags.items()
                ),
            ]
            try:
                return str(read_expression(text, table(*quantities)))
            except RequestError as error:
                hint = f"{error.hint} It can be {RUNS_ON!r}, or a criterion such as peak < 10deg or ending != fell."
                raise RequestError(error.message, hint=hint.strip()) from None

    def _table(
        self,
        word: str,
        make: Callable[[str, Any], _Made],
        instead: str = "Write the expression in quotes.",
        example: str = "",
    ) -> tuple[_Made, ...]:
        """Return the results of `make` for each name and text of a word; the text is None for True."""
        node = self._given.get(word)
        if node is None:
            return ()
        if not isinstance(node, ast.Dict):
            self._source.refuse(
                node.lineno,
                f"the word {word} takes names, each with a text",
                _as_table(word, example or f"my_{_CALLED[word]}", node),
            )
        if len(node.keys) > _MOST:
            self._source.refuse(
                node.lineno, f"the word {word} takes at most {_MOST} names", "Remove some of them."
            )
        found: dict[str, _Made] = {}
        for key, value in zip(node.keys, node.values, strict=True):
            with self._source.at(key or value, f"the word {word}"):
                name = _text(key)
                check_name(name, tuple(found), (*OWN_ENDINGS, NO_LABEL))
            with self._source.at(value, f"the {_CALLED[word]} {name}"):
                everything = word == "label" and isinstance(value, ast.Constant) and value.value is True
                found[name] = make(name, None if everything else _text(value, instead))
        return tuple(found.values())


def _text(node: ast.expr | None, instead: str = "Write it in quotes.") -> str:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if is_collection(node):
        instead = "Write one text in quotes, without brackets around it."
    raise RequestError("expected a text in quotes", hint=instead)


def _as_table(word: str, name: str, node: ast.expr) -> str:
    """Return the hint for a word that needs names, with the texts that were given without names."""
    nodes = node.elts if isinstance(node, ast.List | ast.Tuple | ast.Set) else [node]
    given = [each.value for each in nodes if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    # a single word is a name rather than an expression
    texts = [text for text in given if re.search(r"[<>=\s]", text)]
    names = [name, *(f"{name}{number}" for number in range(2, len(texts) + 1))]
    rows = ", ".join(f'"{key}": "{text}"' for key, text in zip(names, texts or ["..."], strict=False))
    return f"Write {word}={{{rows}}}."
