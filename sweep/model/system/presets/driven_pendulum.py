from sweep.systems import cos, sin, system


@system(duration="200", ends={"turned": "abs(angle) > pi"}, measures={"peak": "max abs(angle)"}, stable="runs on",
        theory={"torque": "2*damping/pi*(exp(pi*drive/2) + exp(-pi*drive/2))"})
def driven_pendulum(angle=0.0, speed=0.0, *, damping=0.1, torque=0.5, drive=0.8, t):
    """Driven pendulum: which torques turn it over"""
    return speed, torque*cos(drive*t) - damping*speed - sin(angle)
