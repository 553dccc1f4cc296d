"""The codes of all endings of a motion with losses; `sweep.model.lossy_disk.tables` explains them."""

NOT_COMPUTED = 0
FLAT = 1
REST = 2
HORIZON = 3
LIFT_OFF = 4
SLIP = 5
UNDISTURBED = 6
UNRESOLVED = 7
INVALID = 8

#: Only for other bodies.
EDGE_CHANGE = 9
