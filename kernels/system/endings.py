"""Codes of endings of a system; those of its events follow."""

#: The duration is over; the cell could not be computed; both legs end in different ways, which no leg knows alone.
RUNS_ON, UNRESOLVED, DIFFERENT, FIRST_EVENT = 1, 2, 3, 4
