"""The codes of all ways in which a motion with losses can end; `sweep.model.lossy_disk.tables` says what they mean."""

NOT_COMPUTED = 0
FLAT = 1
REST = 2
HORIZON = 3
LIFT_OFF = 4
SLIP = 5
UNDISTURBED = 6
UNRESOLVED = 7
INVALID = 8

#: Of other bodies alone.
EDGE_CHANGE = 9
