"""Datasets in files: written aside, checked and published by one rename; opened, looked at and exported."""
