import numpy as np
import pytest
from messages import refused, with_facts

import sweep
from sweep.figures import panels, plots
from sweep.model.disk.contact import slipping

pytestmark = pytest.mark.compiled


@pytest.fixture(scope="module")
def rolling():
    """Return a small atlas with contact forces."""
    spec = sweep.SweepSpec.preset("rolling").replace(
        roll_rate="1:4:12", tilt="0.1deg:20deg:10", contact="yes"
    )
    return sweep.run(spec)


@pytest.mark.slow_lane
def test_a_map_shows_where_the_disk_would_slip(rolling):
    """Cells that need more than the friction coefficient, or lift off, are hatched and named in the legend."""
    shown = panels.panel(rolling, slipping(rolling, 0.3))
    needed = rolling["friction_needed"].transpose("roll_rate", "tilt").values
    assert shown.marked.any()
    assert (shown.marked == (np.isnan(needed) | (needed > 0.3))).all()
    labels = plots.figure([rolling], 0.3).axes[0].get_legend_handles_labels()[1]
    assert with_facts(labels, "slips", "lifts off", "0.3")
    labels = plots.figure([rolling]).axes[0].get_legend_handles_labels()[1]
    assert not any("slips" in label for label in labels)
    profile = plots.figure([rolling.isel(tilt=-1)], 0.3).axes[0].get_legend_handles_labels()[1]
    assert with_facts(profile, "slips", "lifts off", "0.3")


def test_friction_needs_the_forces():
    """An atlas without contact=yes has no forces; the refusal says how to get them."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:3", tilt="0.1deg:20deg:3")
    atlas = sweep.run(spec)
    assert "friction_needed" not in atlas
    with refused("contact=yes"):
        plots.figure([atlas], 0.5)
