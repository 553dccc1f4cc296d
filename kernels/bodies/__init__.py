"""Bodies of revolution that roll without slipping and without losses, where their meridian is an arc of a circle."""
