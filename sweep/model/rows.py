"""Values of several parameters of a request together, for rules that combine them.

A grid combines all values of its parameters, so the largest value of one meets the smallest of another. A table of
starts has only the combinations of its rows.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.model.quantity import Array, Truths

#: The value of a parameter that can break a rule: the largest, the smallest, or the one with the largest magnitude.
LARGEST, LEAST, SIZE = "largest", "least", "size"


def ends_of(value: Any) -> tuple[float, float]:
    """Return the smallest and the largest value of a word; 0 for text."""
    if isinstance(value, str):
        return 0.0, 0.0
    low, high = value.ends() if hasattr(value, "ends") else (value, value)
    return float(low), float(high)


def is_column(value: Any) -> bool:
    """Return whether the value of a parameter is a column of a table."""
    return hasattr(value, "table")


def worst_cases(values: Mapping[str, Any], which: Mapping[str, str]) -> dict[str, Array]:
    """Return the values of parameters that break a rule first.

    Parameters
    ----------
    values : mapping of str to value
        The value of every word of a request.
    which : mapping of str to str
        Parameter -> which of its values: `LARGEST`, `LEAST`, or the one of the largest `SIZE`.

    Returns
    -------
    dict of str to array
        The rows of a column of a table, shape (n,), or one number, shape (). NaN, shape (), for a table whose values
        were not loaded: they were checked when the request was made.
    """
    return {name: _worst(values[name], kind) for name, kind in which.items()}


def _worst(value: Any, kind: str) -> Array:
    if is_column(value):
        known = value.table is not None and value.table.columns is not None
        return np.asarray(value.table.values(value.name) if known else np.nan)
    low, high = ends_of(value)
    if kind == SIZE:
        return np.asarray(max(low, high, key=abs))
    return np.asarray(high if kind == LARGEST else low)


def spell_values(values: Mapping[str, Any], wrong: Truths, *names: str, unit: str = "") -> str:
    """Return the values of parameters as the request has them; for a table, the first row that breaks a rule.

    Parameters
    ----------
    values : mapping of str to value
    wrong : array of bool, shape (n,) or ()
        Which rows break a rule, from `worst_cases`.
    *names : str
    unit : str
        Unit of the values of a table, with a leading space.
    """
    if not wrong.ndim:
        return " ".join(f"{name}={values[name]}" for name in names)
    row = int(np.argmax(wrong))
    parts = [
        f"{name}={values[name].table.values(name)[row]:.6g}{unit}"
        if is_column(values[name])
        else f"{name}={values[name]}"
        for name in names
    ]
    return f"{' '.join(parts)} in row {row + 1} of the table"
