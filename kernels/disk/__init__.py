"""The thin disk that rolls without slipping and without losses."""
