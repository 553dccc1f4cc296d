"""Tests of the explorer's page in a real browser; they are a package, so that they share one browser."""
