"""Codes of endings of a system, which the codes of its events follow; and the kinds of its moments."""

#: The duration is over; the legs end in different ways (set after comparing them).
RUNS_ON, DIFFERENT = 1, 2

#: Failures: a value is not finite; the step that its terms allow does not advance the time; a rate differs from the
#: series of the last step; too many steps.
UNRESOLVED, GROWS, JUMPS, ENDLESS = FAILURES = 3, 4, 5, 6

FIRST_EVENT = 7

#: When a condition became true for the first or the last time, and when a value was greatest.
FIRST, LAST, GREATEST = 0, 1, 2
