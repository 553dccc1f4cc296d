"""Users' systems: right-hand side, endings and measures, as data."""
