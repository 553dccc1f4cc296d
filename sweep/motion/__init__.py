"""Single motions in time, from the kernels or SciPy, and linear theory for comparison."""
