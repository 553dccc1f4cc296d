"""Boundary quantities have the name and the units of their parameter."""

from sweep.atlas.cf_metadata import EDGES, edge_names, edge_quantities, point_quantities, status_name
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS


def test_edge_quantities_follow_their_axis():
    """Edge quantities are named after the axis, the lower edge with `lower_`; all but the flag have its units."""
    for edge, side in [("upper", ""), ("lower", "lower_")]:
        quantities = edge_quantities(DISK, "precession_rate", edge)
        assert list(quantities) == [
            f"boundary_{side}precession_rate",
            f"boundary_{side}precession_rate_halfwidth",
            f"predicted_{side}precession_rate",
            f"critical_{side}precession_rate",
            f"boundary_{side}precession_rate_status",
        ]
        names = edge_names("precession_rate", edge)
        assert tuple(quantities) == (*names, status_name("precession_rate", edge))
        assert {quantities[name].units for name in names} == {PARAMETERS["precession_rate"].units}


def test_the_edges_have_names_of_their_own():
    """No name is used for two edges, and a measured edge states its stable side."""
    names = [name for edge in EDGES for name in edge_names("roll_rate", edge)]
    assert len(names) == len(set(names))
    for edge, side in (("upper", "above"), ("lower", "below")):
        measured = edge_names("roll_rate", edge)[0]
        assert side in edge_quantities(DISK, "roll_rate", edge)[measured].long_name


def test_a_point_of_a_curve_has_a_place_along_every_axis():
    """Points have a place and a half-width along each axis of the atlas, in the units of the axis."""
    quantities = point_quantities(PARAMETERS, ("tilt", "roll_rate"))
    assert {name: quantity.units for name, quantity in quantities.items()} == {
        "curve_tilt": "rad",
        "curve_tilt_halfwidth": "rad",
        "curve_roll_rate": "rad s-1",
        "curve_roll_rate_halfwidth": "rad s-1",
    }
