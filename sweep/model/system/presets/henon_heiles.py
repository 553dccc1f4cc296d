from sweep.systems import system


@system(duration="100", stable="runs on", conserved="(u**2 + v**2 + x**2 + y**2)/2 + x**2*y - y**3/3",
        ends={"top": "y > 1.2", "left": "-sqrt(3)*x - y > 2.4", "right": "sqrt(3)*x - y > 2.4"})
def henon_heiles(x=0.0, y=0.0, u=0.5, v=0.5):
    """Henon-Heiles: through which gap a star leaves"""
    return u, v, -x - 2*x*y, -y - x**2 + y**2
