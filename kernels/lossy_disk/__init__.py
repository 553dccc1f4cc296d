"""The thin disk with losses: dry friction, viscous friction and air drag."""
