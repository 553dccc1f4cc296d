"""Data with which the page computes cells of a user's system: its expressions."""

from typing import Any

from sweep.model.system import passes, tables
from sweep.model.system.definition import Constant, Moment, Node, Symbol
from sweep.model.system.model import SystemModel
from sweep.request.spec import SweepSpec


def is_system(spec: SweepSpec | None) -> bool:
    """Return whether a spec is given and asks for a user's system."""
    return spec is not None and isinstance(spec.model, SystemModel)


def system_cells(model: SystemModel) -> dict[str, Any]:
    """Return the data from which the page makes columns of cells (`sweep.model.system.passes`), suitable for JSON."""
    definition = model.definition
    quantities = model.variables
    names = [name for name in quantities if name not in ("stability", "steps", "unproved")]
    end_time = tables.END_TIME
    return {
        "passes": list(passes.PASSES),
        "states": [each.name for each in definition.states],
        "state_ends": [_with_error_name(each.name + tables.AT_END) for each in definition.states],
        "end_time": end_time,
        "end_time_stated": tables.stated(end_time),
        "measures": [
            {
                **_with_error_name(each.name),
                "kind": each.kind,
                "expressions": [_plain(node) for node in each.expressions],
                "moment": None if each.moment is None else _plain_moment(each.moment),
            }
            for each in definition.measures
        ],
        "labels": [[_plain(node) for node in each.all_positive] for each in definition.labels],
        "conserved": [_plain(node) for node in definition.conserved],
        "columns": names,
        "coded": [name for name in names if quantities[name].flags is not None],
        **passes.NUMBERS,
    }


def _with_error_name(name: str) -> dict[str, str]:
    return {"name": name, "stated": tables.stated(name)}


def _plain_moment(moment: Moment) -> dict[str, Any]:
    return {
        "kind": moment.kind,
        "of_condition": moment.is_of_condition,
        "expressions": [_plain(node) for node in moment.expressions],
    }


def _plain(node: Node) -> Any:
    """Return an expression as JSON: a number, a name, or an operation followed by its operands."""
    if isinstance(node, Constant):
        return node.value
    if isinstance(node, Symbol):
        return node.name
    return [node.name, *map(_plain, node.arguments)]
