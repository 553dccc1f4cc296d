"""Compiled arithmetic of the models: floats and arrays in; floats, arrays and codes of endings out."""

# Other distributions use the import name `kernels` too; `sweep` checks this mark before it uses the package.
MARK = "eulerdisk"
