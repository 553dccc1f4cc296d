from sweep.systems import sqrt, system

B = sqrt(3)/2


@system(duration="100", label={"east": "x > 0.5", "north": "y > 0.4", "south": "y < -0.4"})
def magnets(x=0.4, y=0.3, u=0.0, v=0.0, *, spring=0.5, damping=0.2, height=0.25):
    """Magnetic pendulum: over which of three magnets it comes to rest"""
    a = x + 0.5
    east = ((x - 1)**2 + y**2 + height**2)**-1.5
    north = (a**2 + (y - B)**2 + height**2)**-1.5
    south = (a**2 + (y + B)**2 + height**2)**-1.5
    pull = (x - 1)*east + a*(north + south)
    lift = y*east + (y - B)*north + (y + B)*south
    return u, v, -spring*x - damping*u - pull, -spring*y - damping*v - lift
