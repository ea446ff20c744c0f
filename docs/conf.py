# SPDX-License-Identifier: MIT
"""Settings of the documentation site; `python3 scripts/build_docs.py` builds it."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_extensions")]

import shapegoogle_core as sg  # noqa: E402

project = "Shape Google for Blender"
author = "Shape Google for Blender contributors"
copyright = author
version = release = sg.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "myst_parser",
    # Of this folder
    "mathml",
    "page_links",
    "generated_reference",
    "http_reference",
    "concept_figures",
]
exclude_patterns = ["_build", "_extensions", "examples", "plugin_example", "gallery/**/*.ipynb"]
default_role = "py:obj"
# What the tools cannot cross-reference is no fault of a page.
suppress_warnings = ["config.cache"]
if "without_examples" in tags:  # noqa: F821
    suppress_warnings += ["image.not_readable"]

# -- Markdown -----------------------------------------------------------------------------------------------
myst_enable_extensions = ["dollarmath", "deflist"]
# Anchors as GitHub makes them, so that links work there, too.
myst_heading_anchors = 4

# -- API ----------------------------------------------------------------------------------------------------
autosummary_generate = False
autodoc_member_order = "groupwise"
autodoc_typehints = "none"
autodoc_class_signature = "mixed"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

# -- Gallery ------------------------------------------------------------------------------------------------
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "ignore_pattern": r"__init__\.py",
    "within_subsection_order": "gallery_order.ExampleOrder",
    "image_scrapers": ("matplotlib",),
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "show_memory": False,
    "capture_repr": ("_repr_html_",),
    # `build_docs.py --without-examples` sets the tag.
    "plot_gallery": "without_examples" not in tags,  # noqa: F821 - Sphinx defines it
    "copyfile_regex": "",
    "default_thumb_file": None,
    # Every build runs every example: a cached one could hide that it no longer works.
    "run_stale_examples": True,
    "min_reported_time": 1000,
    "write_computation_times": False,
    "show_signature": False,
}

# -- HTML ---------------------------------------------------------------------------------------------------
html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#2456a6", "color-brand-content": "#2456a6"},
    "dark_css_variables": {"color-brand-primary": "#8ab4f8", "color-brand-content": "#8ab4f8"},
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
