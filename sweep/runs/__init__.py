"""Runs that survive: journal of finished blocks, one writer, resume, assembly, failures, more than one machine."""
