"""The version of the distribution. It stands here alone: a tree that was never installed states it too."""

__version__ = "0.1.0"
