"""The commands of `eulerdisk`, one module for each errand; heavy imports stand inside the functions."""
