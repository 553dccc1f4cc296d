"""Datasets to matplotlib figures and animations. Never imported by `sweep` itself."""
