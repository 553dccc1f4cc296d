"""The thin disk with losses: friction of its contact with the table, and drag of the air."""
