"""Lane functions of a system of ordinary differential equations, generated from its right-hand side."""
