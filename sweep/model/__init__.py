"""Models: the base class with its quantities, endings and kernels, and the models of the package."""
