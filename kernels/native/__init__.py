"""Compiling, caching and calling of kernels: plain Python, no arithmetic."""
