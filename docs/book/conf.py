"""Settings of Sphinx for the book; its sources are put together by the package beside this file."""

import tomllib
from pathlib import Path

_root = Path(__file__).resolve().parents[2]

project = "Stiction"
author = "The developers of Stiction"
copyright = author
release = tomllib.loads((_root / "Cargo.toml").read_text())["workspace"]["package"]["version"]
version = release

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
# Formulas are set by the copy of MathJax that this brings: pages need no network.
extensions += ["sphinx.ext.mathjax", "sphinx-mathjax-offline"]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist", "fieldlist"]
# Anchors of headings are those that a forge makes of the same pages.
myst_heading_anchors = 4
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["work"]

html_theme = "furo"
html_title = f"Stiction {release}"
html_theme_options = {"navigation_with_keys": True}
html_show_copyright = False
html_copy_source = False
html_show_sphinx = False
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["book.css"]

autodoc_member_order = "bysource"
# Docstrings say shapes and units; the hints of arrays are long.
autodoc_typehints = "none"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
# What lies outside of the package has its own documentation; this one is built without a network.
nitpick_ignore_regex = [("py:.*", r"(?!stiction).*")]
nitpick_ignore = []
# Words of shapes, such as `nodes`, are also names of several fields.
suppress_warnings = ["ref.python"]

linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_anchors = False
# Publishers answer programs with 403.
linkcheck_allowed_redirects = {r"https://doi\.org/.*": r".*"}


def setup(app):
    """Docstrings below fields stand in the modules of the package, whose classes call themselves those of `stiction`."""
    from importlib import import_module
    from pkgutil import iter_modules

    from sphinx.pycode import ModuleAnalyzer

    package = ModuleAnalyzer.for_module("stiction")
    package.analyze()
    for module in iter_modules(import_module("stiction").__path__):
        if module.name.startswith("_") and module.name not in ("_stiction", "__main__"):
            part = ModuleAnalyzer.for_module(f"stiction.{module.name}")
            part.analyze()
            package.attr_docs.update({place: text for place, text in part.attr_docs.items() if place[0]})
            package.annotations.update(part.annotations)
            package.tagorder.update({name: len(package.tagorder) + at for name, at in part.tagorder.items()})
