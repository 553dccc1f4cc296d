"""Figures and animations of datasets, by matplotlib. `import sweep` does not import this package."""
