"""Balls and spheroids with losses, in components along directions of space: their motion is regular through a pole."""
