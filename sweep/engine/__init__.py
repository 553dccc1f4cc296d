"""From a request to computed blocks: how a grid is cut, the compiled kernels, their calls and what they will cost."""
