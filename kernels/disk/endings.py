"""The codes of all endings of the integration of a cell; `sweep.model.disk.tables` explains them."""

NOT_COMPUTED = 0
BOUNDED = 1
STEADY = 2
HORIZON = 3
FELL = 4
UNRESOLVED = 5
INVALID = 6
#: Only for bodies with two edges (`kernels.bodies`).
EDGE_CHANGE = 7
