"""What is asked for: parameters with units, ranges and criteria; a sweep or a motion, checked before anything runs."""
