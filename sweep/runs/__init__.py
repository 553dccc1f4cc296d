"""Runs that survive: the journal of finished blocks, one writer, resume, assembly, failures, and more than one machine."""
