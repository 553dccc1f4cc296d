"""Tests of what the explorer's page computes, in Node. They are a package, as those in a browser are."""
