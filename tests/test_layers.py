"""The parts lie as the design says: imports point down, and some words stay out of the package."""

import ast
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "pysindy_evolve"
NAME = PACKAGE.name

# From the bottom up; parts of one layer may use each other, but not in a circle.
LAYERS = (
    {"checks", "lazily", "operators", "terms", "threads", "warn"},
    {"equations", "substitution"},
    {"reading"},
    {"sparse"},
    {"signals", "simulation", "hidden_states"},
    {"breeding"},
    {"evolution"},
    {"handover", "training", "term_library", "library", "optimizer"},
    {"export"},
    {"loop"},
    {"datasets", "paper", "cli"},
    {"__init__", "__main__"},
)
# The same for what the loop is made of.
FLOORS = ("given", "effects", "fitting", "twins", "evidence", "memories", "free_runs", "growth")
FLOORS += ("revision", "search", "facts", "settling", "report", "close")
RANK = {part: rank for rank, layer in enumerate(LAYERS) for part in layer}
MANY = 3  # files in a folder, above which its docstring says what each of them answers


def module_name(path):
    """Dotted name of a source file; a package is named without its __init__."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


def sources():
    return {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def syntax(path):
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def imported_names(path, for_types=True):
    """Dotted names that a file imports, at any depth of its code; relative ones resolved."""
    home = path.relative_to(PACKAGE.parent).with_suffix("").parts[:-1]
    tree = syntax(path)
    left_out = set() if for_types else set(_imports_for_types(tree))
    for node in ast.walk(tree):
        if node in left_out:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = home[: len(home) - node.level + 1] if node.level else ()
            parts = [*base, *(node.module.split(".") if node.module else ())]
            yield from (".".join([*parts, alias.name]) for alias in node.names)


def _imports_for_types(tree):
    """Nodes under ``if TYPE_CHECKING``, which never run."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", None) == "TYPE_CHECKING":
            yield from ast.walk(node)


def internal_imports(path, modules, for_types=True):
    """Modules of the package that a file imports."""
    dotted = [one.split(".") for one in imported_names(path, for_types)]
    return {_longest_module(parts[1:], modules) for parts in dotted if parts[0] == NAME}


def _longest_module(parts, modules):
    """The module that a dotted name lies in: `terms.Sum` lies in `terms`."""
    while parts and ".".join(parts) not in modules:
        parts = parts[:-1]
    return ".".join(parts) or "__init__"


def large_folders():
    """Folders with more files than anybody opens one after the other."""
    folders = sorted({path.parent for path in sources().values()})
    return [folder for folder in folders if len(list(folder.glob("*.py"))) > MANY]


def parts_of(folder):
    """Names of the files and folders that a folder holds, as imports write them."""
    files = {path.stem for path in folder.glob("*.py")} - {"__init__"}
    return files | {path.parent.name for path in folder.glob("*/__init__.py")}


def names_in_table(folder):
    """First column of the table in a folder's docstring; a row without text is a heading."""
    lines = (ast.get_docstring(syntax(folder / "__init__.py")) or "").splitlines()
    rules = [number for number, line in enumerate(lines) if re.fullmatch("=+  =+", line)]
    if not rules:
        return []
    first, last = rules
    width = lines[first].index(" ")
    return [row[:width].strip() for row in lines[first + 1 : last] if row[width:].strip()]


@pytest.fixture(scope="module")
def modules():
    return sources()


@pytest.fixture(params=sorted(sources()))
def module(request):
    return request.param


def test_every_part_has_a_layer(module):
    assert module.split(".")[0] in RANK, f"give {module} a layer in tests/test_layers.py"


def test_imports_point_down(module, modules):
    own = module.split(".")[0]
    for imported in internal_imports(modules[module], modules):
        part = imported.split(".")[0]
        if part != own:
            assert RANK[part] <= RANK[own], f"{module} imports {imported}, which lies above it"


def test_parts_of_the_loop_import_down(modules):
    for name in modules:
        if name.startswith("loop."):
            floor = FLOORS.index(name.split(".")[1])
            for imported in internal_imports(modules[name], modules):
                if imported.startswith("loop."):
                    below = FLOORS.index(imported.split(".")[1])
                    assert below <= floor, f"{name} imports {imported}, which lies above it"


def test_modules_import_each_other_in_no_circle(modules):
    edges = {
        name: internal_imports(path, modules, for_types=False) - {name}
        for name, path in modules.items()
    }
    settled = set()
    while len(settled) < len(edges):
        free = {name for name in edges.keys() - settled if edges[name] <= settled}
        assert free, f"a circle among {sorted(edges.keys() - settled)}"
        settled |= free


def test_what_decides_and_what_tells_takes_an_outcome_and_not_the_report(modules):
    """The report imports all that tells it, so that these files would be one circle."""
    users = {
        name
        for name, path in modules.items()
        if "loop.report.report" in internal_imports(path, modules)
    }
    assert users == {"loop", "loop.close"}


def test_deap_is_imported_in_one_file(modules):
    users = {
        name
        for name, path in modules.items()
        if any(one.split(".")[0] == "deap" for one in imported_names(path))
    }
    assert users == {"breeding.genetics"}


def test_nothing_private_is_imported_from_other_packages(module, modules):
    foreign = [one.split(".") for one in imported_names(modules[module])]
    private = [
        ".".join(parts)
        for parts in foreign
        if parts[0] not in (NAME, "__future__") and any(part.startswith("_") for part in parts)
    ]
    assert private == []


def test_nothing_is_executed_printed_or_asserted(module, modules):
    forbidden = {"eval", "exec"} | (
        set() if module.split(".")[0] in {"cli", "__main__"} else {"print"}
    )
    found = []
    for node in ast.walk(syntax(modules[module])):
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) in forbidden:
            found.append(f"line {node.lineno}: {node.func.id}")
        elif isinstance(node, ast.Assert):
            found.append(f"line {node.lineno}: assert")
    assert found == []


def test_no_handler_catches_everything(module, modules):
    found = []
    for node in ast.walk(syntax(modules[module])):
        if isinstance(node, ast.ExceptHandler):
            caught = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
            names = {getattr(one, "id", None) for one in caught}
            if node.type is None or names & {"Exception", "BaseException"}:
                found.append(f"line {node.lineno}")
    assert found == []


@pytest.mark.parametrize("folder", large_folders(), ids=lambda folder: folder.name)
def test_large_folder_says_what_each_of_its_files_answers(folder):
    named, parts = names_in_table(folder), parts_of(folder)
    assert named, f"{folder}/__init__.py has no table of its files; see loop/settling for its form"
    assert parts - set(named) == set(), f"the table in {folder}/__init__.py misses a file"
    assert set(named) - parts == set(), f"{folder}/__init__.py names what is not there"
    assert len(named) == len(parts), f"{folder}/__init__.py names a file twice"


def test_table_of_the_loop_has_its_floors_in_their_order():
    loop = PACKAGE / "loop"
    assert names_in_table(loop) == [one for one in FLOORS if (loop / one / "__init__.py").exists()]
