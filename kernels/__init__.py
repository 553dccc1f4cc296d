"""Compiled arithmetic of the rolling disk: floats and arrays in, floats, arrays and an ending out."""

# Other distributions own the import name `kernels` too; `sweep` looks for this mark before it trusts what it found.
MARK = "eulerdisk"
