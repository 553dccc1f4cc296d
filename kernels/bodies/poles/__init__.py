"""Balls and spheroids, which roll through their poles, in variables that are regular where the axis is vertical."""
