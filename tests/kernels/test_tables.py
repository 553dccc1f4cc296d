"""Constants next to a table of row names are the numbers of its rows."""

import ast
import importlib

import pytest
from processes import CHECKOUT

MODULES = sorted(
    ".".join(path.relative_to(CHECKOUT).with_suffix("").parts)
    for path in (CHECKOUT / "kernels").glob("*/*.py")
    if path.name.endswith("arrays.py") or path.name == "shapes.py"
)


def tables(module):
    """Yield the constants of each table, ``A, B = range(len(TABLE))`` or by their places, and its name."""
    tree = ast.parse((CHECKOUT / f"{module.replace('.', '/')}.py").read_text(encoding="utf-8"))
    for line in tree.body:
        match line:
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=value):
                named = [
                    node.id for node in ast.walk(value) if isinstance(node, ast.Name) and node.id.isupper()
                ]
                if named:
                    yield [name.id for name in names], named[-1]


@pytest.mark.parametrize("module", MODULES)
def test_constants_have_the_order_of_their_table(module):
    """A constant consists of words of its row, after the table's name: `FRICTION_ALONG` is not "friction_across"."""
    content = importlib.import_module(module)
    for constants, table in tables(module):
        names = getattr(content, table)
        for constant in constants:
            row = names[getattr(content, constant)]
            first, _, rest = constant.partition("_")
            words = (rest if rest and table.startswith(first) else constant).lower().split("_")
            assert set(words) <= set(row.split("_")), (table, constant, row)


def test_all_tables_are_seen():
    """The search finds more than 15 tables."""
    assert sum(1 for module in MODULES for _ in tables(module)) > 15
