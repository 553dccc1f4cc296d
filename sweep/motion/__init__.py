"""Single motions in time, by the kernels or by SciPy, and linear theory for comparison."""
