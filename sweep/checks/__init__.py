"""Checks of atlases: against the exact reduction, against a reference atlas, and of one cell in detail."""
