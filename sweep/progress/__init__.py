"""Progress of work: its stages and remaining time, shown as bars or as lines in a log."""
