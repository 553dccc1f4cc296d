"""Balls and spheroids, in variables that stay regular where the axis is vertical: they roll on through their poles."""
