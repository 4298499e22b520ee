"""Docstrings against signatures: every public function explains every argument and its errors."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = ["control", "vision", "datasets", "pipeline"]
Function = ast.FunctionDef | ast.AsyncFunctionDef


def public_functions() -> Iterator[tuple[str, Function]]:
    """Public functions and methods of public classes, with a readable name."""
    for floor in FLOORS:
        for path in sorted((ROOT / floor).rglob("*.py")):
            tree = ast.parse(path.read_text())
            for node in tree.body:
                owners = [node] if isinstance(node, Function) else []
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    owners = [f for f in node.body if isinstance(f, Function)]
                for function in owners:
                    if not function.name.startswith("_"):
                        yield f"{path.relative_to(ROOT)}:{function.name}", function


FUNCTIONS = list(public_functions())


def arguments_of(function: Function) -> set[str]:
    """Names of the arguments a caller gives."""
    spec = function.args
    names = [a.arg for a in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs)]
    return set(names) - {"self", "cls"}


def section(doc: str, title: str) -> str:
    """The text of one section of a docstring."""
    found = re.search(rf"^{title}:\n((?:[ \t]+.*\n?|\n)*)", doc + "\n", re.MULTILINE)
    return found.group(1) if found else ""


def raised_in(function: Function) -> set[str]:
    """Names of Echelon's own errors that the body raises itself."""
    names = set()
    for node in ast.walk(function):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            name = getattr(node.exc.func, "id", "")
            if name.endswith("Error") and name != "NotImplementedError":
                names.add(name)
    return names


def is_command(name: str) -> bool:
    """Whether it is a sub-command: the help texts of its options document its arguments."""
    path, _, function = name.partition(":")
    own = {f"pipeline/cli/{function}.py", f"pipeline/cli/calibrate_{function}.py"}
    return path in own or name == "pipeline/cli/main.py:general"


@pytest.mark.parametrize(("name", "function"), FUNCTIONS, ids=[n for n, _ in FUNCTIONS])
def test_docstring_matches_signature(name: str, function: Function) -> None:
    doc = ast.get_docstring(function)
    assert doc, f"{name} has no docstring"
    if is_command(name):
        return
    described = set(re.findall(r"^\s+\*{0,2}(\w+):", section(doc, "Args"), re.MULTILINE))
    missing = arguments_of(function) - described
    assert not missing, f"{name}: arguments not described: {missing}"
    strange = set(re.findall(r"^    (\w+):", section(doc, "Args"), re.MULTILINE))
    assert strange <= arguments_of(function), f"{name}: describes {strange}, which are no arguments"
    returns = ast.unparse(function.returns) if function.returns else "None"
    is_property = any("property" in ast.unparse(d) for d in function.decorator_list)
    if returns != "None" and not is_property:
        assert re.search(r"^(Returns|Yields):", doc, re.MULTILINE), (
            f"{name}: says not what it returns"
        )
    for error in raised_in(function):
        assert error in section(doc, "Raises"), f"{name}: raises {error} without saying so"
