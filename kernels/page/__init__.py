"""What the module of a page holds besides the kernels that atlases are computed with."""
