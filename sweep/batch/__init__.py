"""Many sweeps after one another: read from spec files, computed, verified, and compared with trusted atlases."""
