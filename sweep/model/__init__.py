"""What a model is to the engine: quantities, endings, starts, kernels, theory; and the models that come with it."""
