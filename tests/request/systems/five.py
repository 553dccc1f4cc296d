"""Five systems as a user writes them; tests read this file and also import its plain functions."""

from sweep.systems import cos, sin, system

R3 = 0.8660254037844386


@system(
    duration="60 s",
    measures={"greatest": "max abs(rate)"},
    label={"turning": "abs(angle) > 3*pi", "swinging": True},
)
def driven_pendulum(
    angle: "rad" = 0.2,
    rate: "rad/s" = 0.0,
    *,
    damping: "1/s" = 0.5,
    torque: "1/s2" = 0.9,
    drive: "rad/s" = 0.6667,
    natural: "rad/s" = 1.0,
    t,
):
    """Pendulum with a periodic torque.

    The second line is no title.
    """
    return rate, torque * cos(drive * t) - damping * rate - natural**2 * sin(angle)


@system(duration="100", label={"left": "x < 0", "right": "x > 0"})
def duffing(x=1.0, v=0.0, *, damping=0.25, force=0.2, drive=1.0, t):
    return v, x - x**3 - damping * v + force * cos(drive * t)


@system(duration=60, label={"east": "x > 0.5", "north": "y > 0.4", "south": "y < -0.4"})
def magnetic_pendulum(x=0.4, y=0.3, u=0.0, v=0.0, *, spring=0.5, damping=0.2, height=0.25):
    east = ((x - 1) ** 2 + y**2 + height**2) ** -1.5
    north = ((x + 0.5) ** 2 + (y - R3) ** 2 + height**2) ** -1.5
    south = ((x + 0.5) ** 2 + (y + R3) ** 2 + height**2) ** -1.5
    return (
        u,
        v,
        -spring * x - damping * u - (x - 1) * east - (x + 0.5) * (north + south),
        -spring * y - damping * v - y * east - (y - R3) * north - (y + R3) * south,
    )


@system(
    duration="200",
    ends={"top": "y > 1.2", "left": "x - 1.7320508*y > 2.4", "right": "-x - 1.7320508*y > 2.4"},
    conserved="(u**2 + v**2 + x**2 + y**2)/2 + x**2*y - y**3/3",
    stable="runs on",
)
def henon_heiles(x=0.0, y=0.0, u=0.4, v=0.4):
    return u, v, -x - 2 * x * y, -y - x**2 + y**2


@system(
    duration="10 s",
    ends={"fell": "abs(angle) > pi/2"},
    measures={"peak": "max abs(angle)"},
    stable="runs on",
    theory={"shake": "sqrt(2*gravity*length)/amplitude"},
)
def kapitza(
    angle: "rad" = "3 deg",
    speed: "rad/s" = 0.0,
    *,
    length: "cm" = 20,
    amplitude: "m" = 0.02,
    shake: "rad/s" = 60.0,
    gravity: "m/s2" = 9.81,
    t,
):
    """Pendulum on a shaken pivot, upside down."""
    lift = gravity - amplitude * shake**2 * cos(shake * t)
    return speed, lift / length * sin(angle)
