"""Atlases as labelled datasets: verdicts, measured and predicted boundaries, other criteria, refinement, selections."""
