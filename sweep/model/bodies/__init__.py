"""Bodies of revolution that roll without slipping and without losses: torus, rounded or thick disk, ball, spheroid."""
