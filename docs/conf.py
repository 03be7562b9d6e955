"""Configuration of the documentation, which builds without a network."""

import os
import re
import warnings
from pathlib import Path

from pysindy_evolve import __version__

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "examples"
LOADER = re.compile(r"\bload_\w+\(")  # an example that needs measured records

project = "pysindy_evolve"
author = "The pysindy_evolve developers"
version = release = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",  # a script tag in the pages; nothing is fetched while building
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery/**/*.ipynb", "gallery/*.ipynb", "sg_execution_times.rst"]
templates_path = ["_templates"]

autosummary_generate = True
autodoc_typehints = "none"  # the types stand in the docstrings, with shapes and units
numpydoc_show_class_members = False
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"pysindy_evolve {version}"
html_static_path = ["_static"]
html_css_files = ["width.css"]
html_show_copyright = False  # the license says it

warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")


def measured_records_present() -> bool:
    """Whether the examples on measured records can run; they are shown without output if not."""
    folder = os.environ.get("PYSINDY_EVOLVE_DATA", HERE.parents[1] / "shared" / "data")
    return Path(folder).is_dir()


def executed_examples() -> str:
    """Pattern of the example files that are run."""
    runnable = [
        path.stem
        for path in sorted(EXAMPLES.glob("*.py"))
        if measured_records_present() or not LOADER.search(path.read_text(encoding="utf-8"))
    ]
    return "|".join(rf"{stem}\.py" for stem in runnable) or r"\A\Z"


sphinx_gallery_conf = {
    "examples_dirs": str(EXAMPLES),
    "gallery_dirs": "gallery",
    "filename_pattern": executed_examples(),
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "parallel": True,  # with sphinx -j
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
    "remove_config_comments": True,
}
