"""The model of bodies of revolution that roll without slipping, with losses."""
