"""Checks of atlases: against the exact reduction, against a reference atlas, and one cell in detail."""
