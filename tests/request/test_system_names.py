"""Names of a system that would make an atlas unreadable are refused before anything is computed."""

import pytest

import sweep
from sweep.errors import RequestError
from sweep.request.system_file import read_system
from sweep.request.system_words import reserved

TEXT = """
@system(duration="1", measures={{"{measure}": "max abs(x)"}}, stable="{measure} < 2")
def falling(x=1.0, v=0.0, *, {parameter}=1.0):
    return v, -{parameter}*x
"""


def test_what_a_file_holds_is_no_name(tmp_path):
    """Every attribute and dimension written for a boundary in two axes is a reserved name."""
    path = tmp_path / "falling.py"
    path.write_text(f"from sweep.systems import system\n{TEXT.format(measure='peak', parameter='stiffness')}")
    atlas = sweep.run(str(path), stiffness="0.1:9:5", x="0.5:3:5", progress=False)
    names = {*atlas.attrs, *atlas.dims, *atlas.variables} - {"x", "v", "stiffness", "peak"}
    begun = ("boundary_", "predicted_", "critical_", "curve_", "eulerdisk_")
    kept = {
        name
        for name in names
        if not name.startswith(begun) and not name.endswith(("_end", "_error", "_units"))
    }
    assert kept <= reserved()
    assert {"history", "summary", "source"} <= kept


@pytest.mark.parametrize(
    "name",
    [
        "history",
        "summary",
        "source",
        "date_created",
        "eulerdisk_format",
        "curve_closed",
        "boundary_x",
        "predicted_k",
    ],
)
def test_names_of_the_file_are_refused(name):
    """Parameters and measures are refused alike; the message suggests another name."""
    for given in ({"measure": "peak", "parameter": name}, {"measure": name, "parameter": "stiffness"}):
        with pytest.raises(RequestError) as refused:
            read_system(TEXT.format(**given))
        assert name in str(refused.value)
