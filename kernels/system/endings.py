"""Codes of endings of a system; those of its events follow."""

#: The duration is over; legs end in different ways, which no leg knows alone.
RUNS_ON, DIFFERENT = 1, 2

#: It could not be followed: a value is no number; the step that its terms allow does not move the time; a rate is not
#: that of the series of the last step; too many steps.
UNRESOLVED, GROWS, JUMPS, ENDLESS = FAILURES = 3, 4, 5, 6

FIRST_EVENT = 7
