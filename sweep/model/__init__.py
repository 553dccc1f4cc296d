"""What the engine may know of a model: its quantities, endings and starts, and what it can say beyond integration."""
