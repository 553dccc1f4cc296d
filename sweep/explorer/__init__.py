"""The explorer: a map of two parameters on a page of this machine, recomputed as you move around in it."""
