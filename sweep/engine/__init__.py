"""Computation of blocks of cells: the division of a grid, and the calls of the compiled kernels."""
