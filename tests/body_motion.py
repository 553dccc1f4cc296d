"""One motion of a body in space: vectors from its samples, and from the referee for the same start."""

import body_referee
import numpy as np
from body_referee import Body

#: The vectors to compare.
COMPARED = ("axis", "painted", "turning", "centre", "contact", "force")


def in_space(of):
    """Return vectors in space, shape (n, 3) each, from samples: a mapping of names to arrays, scaled.

    Positive tilts lean toward (cos heading, sin heading); the painted direction points to the plane at roll angle 0.
    """
    tilt, heading, angle = of["tilt"], of["heading"], of["roll_angle"]
    sin, cos = np.sin(tilt)[:, None], np.cos(tilt)[:, None]
    aside = np.stack([np.cos(heading), np.sin(heading), 0.0 * tilt], axis=-1)
    ahead = np.stack([-np.sin(heading), np.cos(heading), 0.0 * tilt], axis=-1)
    up = body_referee.UP
    axis, down = sin * up - cos * aside, -(sin * aside + cos * up)
    force = (of["friction_across"], aside), (of["friction_along"], ahead), (of["normal_force"], up)
    turning = (of["tilt_rate"], ahead), (of["precession_rate"], up), (of["roll_rate"], axis)
    return {
        "axis": axis,
        "painted": np.cos(angle)[:, None] * down - np.sin(angle)[:, None] * ahead,
        "turning": sum(rate[:, None] * along for rate, along in turning),
        "centre": np.stack([of["centre_x"], of["centre_y"], of["centre_z"]], axis=-1),
        "contact": np.stack([of["contact_x"], of["contact_y"], 0.0 * tilt], axis=-1),
        "force": sum(part[:, None] * along for part, along in force),
    }


def apart(of, body, tilt, rates, times):
    """Return the distance of samples from a rigid body in space: shape (n,) for each of `COMPARED`."""
    found, right = in_space(of), body.path(tilt, *rates, times)
    return {name: np.linalg.norm(found[name] - right[name], axis=-1) for name in COMPARED}


def referee_of(word, arc, moments, tilt):
    """Return the referee's body for an arc; a disk with two edges rolls on the edge on the side of its tilt."""
    core, shift, edge, square = arc
    return Body(core, -shift if word == "rim" and tilt < 0.0 else shift, edge, *moments, square)
