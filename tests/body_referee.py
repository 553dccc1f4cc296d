"""An independent motion of a body of revolution: Newton and Euler for a rigid body in space, by SciPy."""

import math

import numpy as np
from scipy.integrate import solve_ivp

from kernels.bodies.arrays import PARAMETERS
from kernels.bodies.shapes import NAMES
from sweep.model.rigid_body import UP, RigidBody, cross


class Body(RigidBody):
    """A rolling body, with the forces and the path of its motion."""

    def force(self, y):
        """Return the force of the plane on the body: the acceleration of its center of mass plus its weight."""
        rate = self.right_side(0.0, y)
        r, r_rate = self.contact(y[:3], rate[:3])
        return UP - cross(rate[3:], r) - cross(y[3:], r_rate)

    def energy(self, y):
        """Return the energy."""
        n, turning = y[:3], y[3:]
        r, _ = self.contact(n, np.zeros(3))
        velocity = cross(turning, r)
        return 0.5 * turning @ self.inertia(n) @ turning + 0.5 * velocity @ velocity - r[2]

    def path(self, tilt, w, o, s, times):
        """Return the motion of a start at given times: a mapping of names to arrays in space, one row per time.

        ``axis``; ``painted``, a direction of the body that points to the plane at the start; ``centre`` of mass
        relative to the contact point of the start; ``contact`` point; ``turning`` and ``force``; shape (n, 3) each.
        """
        first = self.start(tilt, w, o, s)
        begin, _ = self.contact(first[:3], np.zeros(3))
        painted = np.array([-math.sin(tilt), 0.0, -math.cos(tilt)])

        def slope(t, y):
            r, _ = self.contact(y[:3], np.zeros(3))
            return np.concatenate([self.right_side(t, y[:6]), -cross(y[3:6], r), cross(y[3:6], y[9:])])

        found = solve_ivp(
            slope, (0.0, times[-1]), np.concatenate([first, -begin, painted]), method="DOP853", t_eval=times,
            rtol=1e-13, atol=1e-14,
        ).y.T  # fmt: skip
        from_centre = np.array([self.contact(n, np.zeros(3))[0] for n in found[:, :3]])
        return {
            "axis": found[:, :3], "turning": found[:, 3:6], "centre": found[:, 6:9], "painted": found[:, 9:],
            "contact": found[:, 6:9] + from_centre, "force": np.array([self.force(y[:6]) for y in found]),
        }  # fmt: skip


#: Bodies of the table of reference values, each with its extreme tilts and period for a tilt of 0.2 and rates of 0.1,
#: 0.5, 0.6, from integrating another form of the equations (nine unknowns, a quaternion).
REFERENCE = {
    "disk": (Body(1.0, 0.0, 0.0, 0.5, 0.25), 0.1901938954, 1.3974733365, 4.6209812490),
    "torus": (Body(0.75, 0.0, 0.25, 0.609375, 0.3203125), 0.1891635973, 1.3656664734, 4.8132291339),
    "hollow": (Body(0.7, 0.0, 0.3, 0.625, 0.3575), 0.1886831570, 1.4034772698, 4.9110760122),
    "edge": (Body(0.9, 0.0, 0.1, 0.47998914980, 0.24319566028), 0.1897916375, 1.3886958061, 4.6601473860),
    "ball": (Body(0.0, 0.2, 1.0, 0.42, 0.38), 0.1438704053, 1.0565609692, 17.2560929788),
    "oblate": (Body(0.0, 0.0, 1.0, 0.4, 0.25, 0.25), 0.1885850821, 1.4309369510, 4.6787236735),
    "prolate": (Body(0.0, 0.0, 1.0, 0.4, 0.65, 2.25), 0.1169029511, 0.3339814542, 6.7548336763),
}

#: Body of that table -> its name as an input, and a function for its lengths.
LENGTHS = {
    "disk": ("torus", lambda body: {"tube": 0.0}),
    "torus": ("torus", lambda body: {"tube": body.edge}),
    "hollow": ("torus", lambda body: {"tube": body.edge}),
    "edge": ("rounded", lambda body: {"thickness": 2.0 * body.edge}),
    "ball": ("ball", lambda body: {"offset": body.shift}),
    "oblate": ("spheroid", lambda body: {"flattening": 0.5}),
    "prolate": ("spheroid", lambda body: {"flattening": -0.5}),
}


def starts(n=1, **parameters):
    """Return float64[len(PARAMETERS), n] for radius 1 and gravity 1; other parameters default to 0."""
    given = {"radius": 1.0, "gravity": 1.0, **parameters}
    return np.stack([np.broadcast_to(np.float64(given.get(name, 0.0)), n) for name in PARAMETERS])


def start_of(name, tilt, w, o, s, axial, transverse, **lengths):
    """Return one start of a body with scaled rates, and the number of the body."""
    precession = o / math.cos(tilt)
    return starts(
        tilt=tilt, tilt_rate=w, precession_rate=precession, roll_rate=s - precession * math.sin(tilt),
        axial_moment=axial, transverse_moment=transverse, **lengths,
    ), NAMES.index(name)  # fmt: skip
