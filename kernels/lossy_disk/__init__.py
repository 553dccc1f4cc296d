"""The thin disk with losses: lever arms of dry friction, viscous friction and drag of air."""
