"""Questions that take several atlases: convergence to the lines, the family of steady motions, its bifurcations."""
