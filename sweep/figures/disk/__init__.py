"""Figures of disks and other bodies: pictures and films of a motion, regimes, losses, and where it would slip."""
