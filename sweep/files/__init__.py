"""Datasets in files: writing to temporary names, checking, publishing by one rename, opening and exporting."""
