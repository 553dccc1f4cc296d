"""The model of the thin disk that rolls without slipping and without losses."""
