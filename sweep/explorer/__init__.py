"""The explorer: a map of two parameters on a page of this machine, computed anew as one looks around in it."""
