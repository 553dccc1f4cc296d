"""Lane functions of a system of ordinary differential equations, made from its right-hand side."""
