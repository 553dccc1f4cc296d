"""Bodies of revolution that roll without slipping and without losses."""
