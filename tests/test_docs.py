"""What the README and the docstrings promise holds."""

import ast
import inspect
import re
import runpy
import textwrap
from dataclasses import is_dataclass

import pytest
from numpydoc.validate import validate

import pysindy_evolve
from pysindy_evolve import datasets
from pysindy_evolve.loop.effects.names import VOCABULARY

# The numpydoc checks a public docstring must pass: it exists and begins with one sentence (GL08,
# SS03), every parameter is described, in order, and none that does not exist (PR01-PR04, PR07),
# and what is returned is named (RT01).
CHECKS = {"GL08", "SS03", "PR01", "PR02", "PR03", "PR04", "PR07", "RT01"}


def public_names():
    yield from (f"pysindy_evolve.{name}" for name in pysindy_evolve.__all__)
    yield from (f"pysindy_evolve.datasets.{name}" for name in datasets.__all__)


def look_up(dotted):
    module = datasets if dotted.startswith("pysindy_evolve.datasets.") else pysindy_evolve
    return getattr(module, dotted.rsplit(".", 1)[1])


def described():
    """Public names that are classes or functions."""
    return [name for name in public_names() if callable(look_up(name))]


@pytest.fixture(scope="module")
def blocks(repository):
    """Language and content of each fenced block of the README, in order."""
    text = (repository / "README.md").read_text(encoding="utf-8")
    return re.findall(r"^```(\w*)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


def test_readme_opens_with_the_purpose(repository):
    text = " ".join((repository / "README.md").read_text(encoding="utf-8").split())
    assert text.startswith(
        "# pysindy_evolve Give it your model and your measurements; it grows the PySINDy terms "
        "your model is missing, proves them on data it has not seen, and hands back the corrected "
        "equation."
    )


@pytest.mark.parametrize(
    ("index", "ending"), [(0, "/pysindy-evolve demo"), (1, "/python -m pytest -n auto")]
)
def test_the_first_two_blocks_of_the_readme_are_single_commands(blocks, index, ending):
    language, command = blocks[index]
    assert language == "bash"
    assert len(command.strip().splitlines()) == 1
    assert command.startswith("python3 -m venv ")
    assert command.strip().endswith(ending)


def test_the_two_commands_use_environments_of_their_own(blocks):
    made = [block.split(" && ")[0] for _, block in blocks[:2]]
    assert len(set(made)) == 2


def test_python_blocks_of_the_readme_parse(blocks):
    for language, code in blocks:
        if language == "python":
            ast.parse(code)


def is_result(name):
    """Whether a class is handed out by a function and not made by the user."""
    return "Attributes\n---" in inspect.getdoc(look_up(name)) and is_dataclass(look_up(name))


@pytest.mark.slow
def test_python_blocks_of_the_readme_run(blocks, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for language, code in blocks:
        if language == "python":
            runpy.run_path(_saved(code, tmp_path))
    printed = capsys.readouterr().out
    shown = [output.strip() for language, output in blocks if language == "text"]
    assert all(output in printed for output in shown)
    assert printed.strip().endswith(shown[-1])  # the README leaves out nothing at the end


@pytest.mark.slow
@pytest.mark.parametrize("page", ["index", "noise"])
def test_python_blocks_of_a_page_run(page, repository, tmp_path):
    text = (repository / "docs" / f"{page}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^ *```python\n(.*?)^ *```$", text, flags=re.MULTILINE | re.DOTALL)
    assert blocks
    for block in blocks:
        runpy.run_path(_saved(textwrap.dedent(block), tmp_path))


def test_no_other_page_has_python_blocks(repository):
    pages = (repository / "docs").glob("*.md")
    found = {page.stem for page in pages if "```python" in page.read_text(encoding="utf-8")}
    assert found == {"index", "noise"}


def _saved(code, folder):
    path = folder / "example.py"
    path.write_text(code, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("name", described())
def test_public_docstring_describes_every_parameter(name):
    # The fields of a result are its attributes, which numpydoc counts as parameters.
    checks = CHECKS - {"PR01"} if is_result(name) else CHECKS
    errors = [f"{code}: {message}" for code, message in validate(name)["errors"] if code in checks]
    assert errors == []


@pytest.mark.parametrize("name", described())
def test_public_callable_with_parameters_has_a_parameters_section(name):
    if inspect.signature(look_up(name)).parameters and not is_result(name):
        assert "Parameters\n---" in inspect.getdoc(look_up(name))


def test_every_public_name_is_in_the_api_pages(repository):
    pages = "\n".join(
        path.read_text(encoding="utf-8") for path in (repository / "docs" / "api").glob("*.rst")
    )
    listed = set(re.findall(r"^   (\w+)$", pages, flags=re.MULTILINE))
    missing = {name.rsplit(".", 1)[1] for name in described()} - listed
    assert missing == set()


def test_every_public_name_is_public_in_its_module():
    for dotted in public_names():
        assert look_up(dotted) is not None


def test_every_dependency_has_its_line_of_justification(repository):
    import tomllib

    project = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"].values()
    wanted = [*project["dependencies"], *(one for extra in extras for one in extra)]
    names = {re.split(r"[>=<]", one)[0] for one in wanted if not one.startswith("pysindy-evolve")}
    page = (repository / "docs" / "dependencies.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^\|(?: `\w+` \|)? ([\w\[\]-]+) \|", page, flags=re.MULTILINE))
    assert names <= listed


def written(node):
    """Text of a string in the source, with … for what is filled in; None for another node."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(
            str(getattr(part, "value", "…")) if isinstance(part, ast.Constant) else "…"
            for part in node.values
        )
    return None


def constraints(path):
    """What the errors of a file demand: the words between "must" and the semicolon."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        called = getattr(node.func, "id", getattr(node.func, "attr", ""))
        texts = [text for text in map(written, node.args) if text is not None]
        if called.startswith("refuse") and len(node.args) > 2:
            yield written(node.args[2]) or ""
        elif called.endswith("Error") or called == "fail":
            for text in texts[:1]:
                _, must, rest = text.partition("must ")
                yield rest.split(";")[0] if must else ""


def test_every_error_of_the_package_is_in_the_table_of_errors(repository):
    page = " ".join((repository / "docs" / "errors.md").read_text(encoding="utf-8").split())
    unlisted = {}
    for path in sorted((repository / "pysindy_evolve").rglob("*.py")):
        for constraint in constraints(path):
            # A part that is filled in differs each time; the longest fixed part names the row.
            part = max(re.split(r"…|\d+", constraint), key=len).strip(" .,:")
            if part not in page:
                unlisted.setdefault(path.name, []).append(constraint)
    assert unlisted == {}


def test_the_table_of_errors_lists_none_that_is_gone(repository):
    page = (repository / "docs" / "errors.md").read_text(encoding="utf-8").split("## Warnings")[0]
    rows = re.findall(r"^\| (?!the message)([^|]*must [^|]*) \|", page, flags=re.MULTILINE)
    listed = [message for row in rows for message in row.split(";")]
    listed += " ".join(page.split("are in the message itself:")[1].split()).split(";")
    said = "\n".join(map(_said, sorted((repository / "pysindy_evolve").rglob("*.py"))))
    fixed = [max(one.partition("must ")[2].split("…"), key=len).strip(" .,:") for one in listed]
    assert len(fixed) > 150
    assert [part for part in fixed if part.removeprefix("be ") not in said] == []


def _said(path):
    """All strings of a file, in their order; "must " and its constraint may be two of them."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return "".join(text for text in map(written, ast.walk(tree)) if text is not None)


def test_every_effect_has_a_row_on_the_page_of_effects(repository):
    page = (repository / "docs" / "effects.md").read_text(encoding="utf-8")
    assert [name for name in VOCABULARY if f"\n| {name} |" not in page] == []
