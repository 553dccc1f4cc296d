from sweep.systems import sin, system


@system(duration="200", label={"above": "x + y + z > 1", "below": "x + y + z < -1", "between": True})
def thomas(x=1.0, y=0.5, z=0.0, *, b=0.3):
    """Thomas' cyclically symmetric system: on which side motions end"""
    return sin(y) - b*x, sin(z) - b*y, sin(x) - b*z
