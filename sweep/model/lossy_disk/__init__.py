"""The thin disk with losses: friction at its contact with the table, and drag of the air."""
