"""How Sphinx builds the site; `scripts/build_site.py` runs it. Sources are the pages of docs/ and those beside it."""

from numpydoc.xref import DEFAULT_LINKS
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

import sweep

project = "eulerdisk"
author = "the eulerdisk authors"
copyright = author
version = release = sweep.__version__

extensions = [
    "myst_nb",  # myst_parser, and notebooks
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "formulas",
    "live",
    "names",
    "notebooks",
    "pictures",
]

# The folder of the sources is the checkout, so that a link leads to the same page here as in the repository.
root_doc = "docs/index"
include_patterns = ["docs/*.md", "docs/tutorials/*.md", "CONTRIBUTING.md", "CHANGELOG.md"]
exclude_patterns = [".*", "site-out", "build", "dist", "atlas-out"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

# Tutorials are notebooks, executed with every build in folders of their own: a cell that raises ends it.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_show_tb = True
nb_execution_timeout = 600  # seconds a cell
nb_output_stderr = "warn"  # so that a warning ends it too

# `name` in a docstring is a link; the build warns of one that leads nowhere.
default_role = "py:obj"
nitpicky = True
autodoc_typehints = "none"  # the sections of a docstring say the types in words
autodoc_member_order = "bysource"
autosummary_generate = False  # it would write pages into the checkout
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_aliases = {name: f"sweep.{name}" for name in sweep.__all__ if name != "__version__"} | {
    "Model": "sweep.model.description.Model"
}
# Words of a type that are none of these names stay words: no inventory of another project is fetched.
DEFAULT_LINKS.clear()
numpydoc_xref_ignore = "all"

html_theme = "pydata_sphinx_theme"
html_title = "eulerdisk"
# `formulas` writes the font of the formulas beside it.
html_static_path = ["_site/style.css"]
html_css_files = ["style.css"]
html_extra_path = ["_site/index.html"]
html_copy_source = False
html_show_sourcelink = False
html_math_renderer = "mathml"
html_show_search_summary = False  # a browser does not fetch pages of a site that it has opened from disk
html_context = {"default_mode": "auto"}
html_theme_options = {
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 8,
    "secondary_sidebar_items": {"**": ["page-toc"]},
    "show_prev_next": True,
    "footer_start": ["copyright"],
    "footer_end": [],
}


def setup(app: Sphinx) -> None:
    """Show what Pygments cannot colour as it is."""
    app.add_lexer("csv", TextLexer)
