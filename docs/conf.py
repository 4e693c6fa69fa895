"""How Sphinx makes the site of these documents; ``docs/site`` calls it."""

from pathlib import Path

from sphinx import addnodes

from tissue_probe import __version__

project = "tissue_probe"
release = __version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/index"
exclude_patterns = ["docs/site"]

# Links name headings as the repository's own pages show them.
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
# Lines of progress are for a terminal.
nb_output_stderr = "remove"

# Arrays, paths and the like are types of others' documents, which would have to be fetched.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "pydata_sphinx_theme"
html_title = "tissue_probe"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
# These pages have no further ones beside them.
html_sidebars = {"docs/questions": [], "docs/gallery": []}
html_theme_options = {
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
}


def _without_folders(app, tree):
    """Leave links to folders of the repository as text: a site shows no folders."""
    for link in list(tree.findall(addnodes.pending_xref)):
        _, path = app.env.relfn2path(link["reftarget"])
        if Path(path).is_dir():
            link.replace_self(link.children)


def setup(app):
    app.connect("doctree-read", _without_folders)
