"""Requests: parameters with units, ranges and criteria, for a sweep or a motion; checked before anything runs."""
