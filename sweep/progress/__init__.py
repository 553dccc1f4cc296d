"""How far some work is, and how people see it: stages and the time to go; bars, and lines in a log."""
