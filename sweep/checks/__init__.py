"""What an atlas is held against: the exact reduction, another atlas, and the words that explain one cell."""
