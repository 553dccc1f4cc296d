"""The colours of the laws of loss, the same in all figures."""

from collections.abc import Mapping

#: Measure of a loss -> colour, of Okabe and Ito's palette: the colour-blind can tell them apart.
COLOURS: Mapping[str, str] = {
    "rolling_loss": "#E69F00",
    "pivoting_loss": "#CC79A7",
    "contour_loss": "#0072B2",
    "damping_loss": "#56B4E9",
    "air_loss": "#009E73",
}
