"""Bodies of revolution that roll without slipping and without losses: torus, rounded disk, disk with an edge, ball."""
