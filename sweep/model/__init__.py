"""Models: quantities, endings, starts, kernels, theory; and the models of the package."""
