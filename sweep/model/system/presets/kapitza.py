from sweep.systems import cos, sin, system


@system(duration="10 s", ends={"fell": "abs(angle) > pi/2"}, measures={"peak": "max abs(angle)"}, stable="runs on",
        theory={"shake": "sqrt(2*gravity*length)/amplitude"})
def kapitza(angle: "rad" = "1 deg", speed: "rad/s" = 0.0, *, length: "m" = 0.2, amplitude: "m" = 0.02,
            shake: "rad/s" = 120.0, gravity: "m/s2" = 9.81, t):
    """Kapitza's pendulum: upside down on a shaken pivot"""
    lift = gravity - amplitude*shake**2*cos(shake*t)
    return speed, lift/length*sin(angle)
