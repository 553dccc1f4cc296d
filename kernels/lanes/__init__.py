"""Machinery that contains no physics: lanes of trajectories side by side, their scheduling and refill."""
