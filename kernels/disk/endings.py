"""The codes of all ways in which the integration of a cell can end; `sweep.model.disk.tables` says what they mean."""

NOT_COMPUTED = 0
BOUNDED = 1
STEADY = 2
HORIZON = 3
FELL = 4
UNRESOLVED = 5
INVALID = 6
#: Of a body with two edges alone (`kernels.bodies`).
EDGE_CHANGE = 7
