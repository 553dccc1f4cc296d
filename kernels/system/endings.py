"""Codes of endings of a system; codes of its events follow."""

#: The duration is over; the legs end in different ways (set after comparing them).
RUNS_ON, DIFFERENT = 1, 2

#: Failures: a value is not finite; the step that its terms allow does not advance the time; a rate differs from the
#: series of the last step; too many steps.
UNRESOLVED, GROWS, JUMPS, ENDLESS = FAILURES = 3, 4, 5, 6

FIRST_EVENT = 7
