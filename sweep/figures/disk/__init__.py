"""What is particular to the disk: pictures and films of its motion, its regimes, and where it would slip."""
