"""Batches of sweeps from spec files: computed one after the other, verified, and compared with trusted atlases."""
