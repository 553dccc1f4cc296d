"""How kernels are compiled, kept and called: plain Python around the compiled arithmetic, and none of it."""
