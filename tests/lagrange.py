"""The disk in Lagrange's form: five coordinates, two rolling constraints, their multipliers.

q = (x, y, psi, theta, phi): contact point, heading, tilt, roll angle. The equations are

M q'' + B + G = W^T lambda, W q' = 0.

In the direction e1 = (cos psi, sin psi) across the track the contact point does not move; along the track, in the
direction e2 = (-sin psi, cos psi), it moves at R phi'. The multipliers are the horizontal forces of the plane on the
disk in those two directions. This is plain NumPy: a slow referee of the fast form.
"""

import numpy as np


def mass_matrix(q, alpha, mass, radius):
    """Return the mass matrix M, shape (..., 5, 5), of coordinates q, shape (..., 5).

    Parameters
    ----------
    q : array, shape (..., 5)
    alpha, mass, radius : float
        Axial moment of inertia over m R^2 [1], mass [kg], radius [m].

    Notes
    -----
    From T = m v^2/2 + alpha m R^2 (phi' + psi' sin theta)^2/2 + alpha m R^2 (theta'^2 + psi'^2 cos^2 theta)/4 with v
    the velocity of (x, y, 0) + R (sin theta cos psi, sin theta sin psi, cos theta).
    """
    cos_psi, sin_psi, cos, sin = _angles(q)
    inertia = mass * radius**2
    M = np.zeros((*np.shape(sin), 5, 5))
    M[..., 0, 0] = M[..., 1, 1] = mass
    M[..., 0, 2] = M[..., 2, 0] = -mass * radius * sin * sin_psi
    M[..., 1, 2] = M[..., 2, 1] = mass * radius * sin * cos_psi
    M[..., 0, 3] = M[..., 3, 0] = mass * radius * cos * cos_psi
    M[..., 1, 3] = M[..., 3, 1] = mass * radius * cos * sin_psi
    M[..., 2, 2] = inertia * ((1.0 + alpha) * sin**2 + 0.5 * alpha * cos**2)
    M[..., 2, 4] = M[..., 4, 2] = inertia * alpha * sin
    M[..., 3, 3] = inertia * (1.0 + 0.5 * alpha)
    M[..., 4, 4] = inertia * alpha
    return M


def velocity_forces(q, v, alpha, mass, radius):
    """Return the terms B, shape (..., 5), that are quadratic in the velocities v = q', shape (..., 5)."""
    cos_psi, sin_psi, cos, sin = _angles(q)
    psi, theta, phi = v[..., 2], v[..., 3], v[..., 4]
    inertia = mass * radius**2
    inward, sideways = sin * (theta**2 + psi**2), 2.0 * cos * theta * psi
    return np.stack(
        [
            -mass * radius * (inward * cos_psi + sideways * sin_psi),
            -mass * radius * (inward * sin_psi - sideways * cos_psi),
            inertia * theta * cos * (alpha * phi + (2.0 + alpha) * psi * sin),
            -inertia * psi * cos * (alpha * phi + (1.0 + 0.5 * alpha) * psi * sin),
            inertia * alpha * cos * theta * psi,
        ],
        axis=-1,
    )


def potential_forces(q, mass, radius, gravity):
    """Return the derivatives G, shape (..., 5), of the potential m g R cos theta."""
    G = np.zeros(np.shape(q))
    G[..., 3] = -mass * gravity * radius * _angles(q)[3]
    return G


def constraint_matrix(q, radius):
    """Return the constraints W, shape (..., 2, 5): W q' = 0 is rolling without slip, across and along the track."""
    cos_psi, sin_psi, _, _ = _angles(q)
    W = np.zeros((*np.shape(sin_psi), 2, 5))
    W[..., 0, 0] = W[..., 1, 1] = cos_psi
    W[..., 0, 1] = sin_psi
    W[..., 1, 0] = -sin_psi
    W[..., 1, 4] = -radius
    return W


def constraint_matrix_rate(q, v):
    """Return the time derivative of W, shape (..., 2, 5)."""
    cos_psi, sin_psi, _, _ = _angles(q)
    W_rate = np.zeros((*np.shape(sin_psi), 2, 5))
    W_rate[..., 0, 0] = W_rate[..., 1, 1] = -sin_psi * v[..., 2]
    W_rate[..., 0, 1] = cos_psi * v[..., 2]
    W_rate[..., 1, 0] = -cos_psi * v[..., 2]
    return W_rate


def accelerations(q, v, alpha, mass, radius, gravity):
    """Return q'' and the multipliers from the system [[M, -W^T], [W, 0]] [q''; lambda] = [-B-G; -W' q'].

    Parameters
    ----------
    q, v : arrays, shape (..., 5)
        Coordinates and velocities [m, rad, m/s, rad/s].
    alpha, mass, radius, gravity : float

    Returns
    -------
    (q'', lambda) : arrays, shapes (..., 5) and (..., 2)
        Accelerations, and the horizontal forces [N] of the plane across and along the track.
    """
    W = constraint_matrix(q, radius)
    saddle = np.zeros((*W.shape[:-2], 7, 7))
    saddle[..., :5, :5] = mass_matrix(q, alpha, mass, radius)
    saddle[..., :5, 5:] = -np.swapaxes(W, -1, -2)
    saddle[..., 5:, :5] = W
    free = velocity_forces(q, v, alpha, mass, radius) + potential_forces(q, mass, radius, gravity)
    bias = (constraint_matrix_rate(q, v) @ v[..., None])[..., 0]
    solution = np.linalg.solve(saddle, -np.concatenate([free, bias], axis=-1)[..., None])[..., 0]
    return solution[..., :5], solution[..., 5:]


def onto_constraints(q, v, alpha, mass, radius):
    """Project v onto rolling without slip, in the kinetic-energy norm: v - M^-1 W^T (W M^-1 W^T)^-1 W v."""
    W = constraint_matrix(q, radius)
    spread = np.linalg.solve(mass_matrix(q, alpha, mass, radius), np.swapaxes(W, -1, -2))
    slip = np.linalg.solve(W @ spread, W @ v[..., None])
    return v - (spread @ slip)[..., 0]


def run(q, v, duration, steps, alpha, mass, radius, gravity):
    """Integrate all five coordinates with RK4 and project the velocities after every step.

    Parameters
    ----------
    q, v : arrays, shape (5,)
        The start; v is projected first.
    duration : float
        Time [s].
    steps : int
        Number of equal steps.
    alpha, mass, radius, gravity : float

    Returns
    -------
    (q, v, slip) : arrays, shapes (steps + 1, 5), (steps + 1, 5) and (steps + 1,)
        Coordinates and velocities after each step, and the largest |W q'| [m/s] that the step left before the
        projection: the loss of the acceleration form of the constraints.

    Notes
    -----
    The projection moves the velocities by the local error of the step, so that the order stays 4.
    """
    h = duration / steps
    qs, vs, slip = np.empty((steps + 1, 5)), np.empty((steps + 1, 5)), np.zeros(steps + 1)

    def rate(y):
        return np.concatenate([y[5:], accelerations(y[:5], y[5:], alpha, mass, radius, gravity)[0]])

    y = np.concatenate([q, onto_constraints(q, v, alpha, mass, radius)])
    qs[0], vs[0] = y[:5], y[5:]
    for i in range(1, steps + 1):
        k1 = rate(y)
        k2 = rate(y + 0.5 * h * k1)
        k3 = rate(y + 0.5 * h * k2)
        k4 = rate(y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        slip[i] = np.abs(constraint_matrix(y[:5], radius) @ y[5:]).max()
        y[5:] = onto_constraints(y[:5], y[5:], alpha, mass, radius)
        qs[i], vs[i] = y[:5], y[5:]
    return qs, vs, slip


def _angles(q):
    """Return (cos psi, sin psi, cos theta, sin theta)."""
    q = np.asarray(q)
    return np.cos(q[..., 2]), np.sin(q[..., 2]), np.cos(q[..., 3]), np.sin(q[..., 3])
