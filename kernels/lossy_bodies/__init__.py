"""Bodies of revolution with losses: the laws of the thin disk, whose control of steps and dry friction they share."""
