"""The commands of `eulerdisk`, grouped by purpose. Heavy imports are inside the functions."""
