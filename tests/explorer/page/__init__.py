"""Tests of the explorer page's computations in Node; a package, like the browser tests."""
