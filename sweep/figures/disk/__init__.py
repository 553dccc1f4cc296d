"""Figures of the disk alone: pictures and films of its motion, its regimes, and where it would slip."""
