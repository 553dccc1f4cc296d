"""Systems of users: a right-hand side, its endings and its measures, as data."""
