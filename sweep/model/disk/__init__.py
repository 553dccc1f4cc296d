"""The thin disk that rolls without slipping and without losses, as the engine knows it."""
