"""Lanes of trajectories side by side, their scheduling and refill; contains no physics."""
