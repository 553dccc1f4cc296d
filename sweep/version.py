"""The version of the distribution, and its home. They stand here alone: a tree never installed states them too."""

__version__ = "0.1.0"

#: Where the program is to be had, as ``[project.urls]`` says; empty as long as it is nowhere.
HOME = ""
