"""The commands of `eulerdisk`, grouped by purpose. The functions do the slow imports."""
