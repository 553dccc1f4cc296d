"""One motion in time, by the kernels or by scipy, and the linear theory beside it."""
