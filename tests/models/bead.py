from sweep.systems import cos, sin, system


@system(duration="10 s", ends={"over": "abs(angle) > pi"}, measures={"lowest": "min angle", "highest": "max angle"},
        conserved="rate**2/2 - hoop_rate**2*sin(angle)**2/2 - gravity/radius*cos(angle)", stable="highest < 10deg",
        theory={"hoop_rate": "sqrt(gravity/radius)"})
def bead(angle: "rad" = "1 deg", rate: "rad/s" = 0.0, *, hoop_rate: "rad/s" = 3.0, radius: "m" = 0.5,
         gravity: "m/s2" = 9.81):
    """Bead on a turning hoop: stability of the bottom"""
    return rate, hoop_rate**2*sin(angle)*cos(angle) - gravity/radius*sin(angle)
