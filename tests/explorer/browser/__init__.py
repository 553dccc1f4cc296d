"""Tests of the explorer's page in a real browser. They are a package, so that one browser serves all of them."""
