"""Moments of inertia from shapes, compared with integrals over the body."""

import math

import pytest
from scipy.integrate import quad

from kernels.bodies.shapes import solid_moments, torus_moments


@pytest.mark.parametrize(
    ("thickness", "fillet"), [(0.1, 0.0), (0.3, 0.05), (0.9, 0.1), (1.4, 0.6), (0.5, 0.25)]
)
def test_moments_of_a_solid_are_those_of_its_slices(thickness, fillet):
    """The moments are sums over slices, disks of radius r at height z: r^4/2 (axis), r^4/4 + z^2 r^2 (across)."""
    straight = 0.5 * thickness - fillet

    def radius(z):
        depth = max(z - straight, 0.0)
        return 1.0 - fillet + math.sqrt(max(fillet * fillet - depth * depth, 0.0))

    def over_axis(integrand):
        pieces = ((0.0, straight), (straight, 0.5 * thickness))
        return sum(quad(integrand, *ends, epsabs=1e-13, epsrel=1e-13)[0] for ends in pieces)

    volume = over_axis(lambda z: radius(z) ** 2)
    axial = over_axis(lambda z: 0.5 * radius(z) ** 4) / volume
    transverse = over_axis(lambda z: 0.25 * radius(z) ** 4 + z * z * radius(z) ** 2) / volume
    assert solid_moments(thickness, fillet) == pytest.approx((axial, transverse), rel=1e-10)


@pytest.mark.parametrize("tube", [0.02, 0.2, 0.5])
def test_moments_of_a_ring_are_integrals_over_its_tube(tube):
    """The moments of a ring and of its skin are integrals around the tube, weighted by the distance from the axis."""
    core = 1.0 - tube

    def mean(integrand, share):
        """Return a mean over the circle at a share of the tube's radius."""

        def weighed(angle):
            distance = core + share * tube * math.cos(angle)
            return distance * integrand(distance, share * tube * math.sin(angle))

        return quad(weighed, 0.0, 2.0 * math.pi, epsabs=1e-13)[0] / (2.0 * math.pi * core)

    def axial(distance, height):
        return distance**2

    def transverse(distance, height):
        return 0.5 * distance**2 + height**2

    skin = [mean(of, 1.0) for of in (axial, transverse)]
    solid = [quad(lambda r, of=of: 2.0 * r * mean(of, r), 0.0, 1.0)[0] for of in (axial, transverse)]
    assert torus_moments(tube, hollow=True) == pytest.approx(skin, rel=1e-10)
    assert torus_moments(tube, hollow=False) == pytest.approx(solid, rel=1e-10)
