"""The exact reduction to one degree of freedom: extremes and periods without time stepping, many cells side by side."""
