"""The version and the home page of the distribution, defined only here so that they exist without installation."""

__version__ = "0.1.0"

#: Home page of the program, as in ``[project.urls]``; empty until it is published.
HOME = ""
