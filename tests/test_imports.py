"""The direction of imports: control <- vision <- datasets <- pipeline, and what each may touch."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = ["control", "vision", "datasets", "pipeline"]
IMPURE = {"time", "datetime", "random", "logging", "socket", "threading", "subprocess", "io"}
BANNED = {
    "control": IMPURE | {"cv2", "os", "pathlib", "serial", "rerun", "mcap", "av", "pydantic"},
    "vision": IMPURE | {"os", "pathlib", "serial", "rerun", "mcap", "av", "pydantic"},
    "datasets": {"serial", "rerun", "socket", "pydantic", "typer"},
}
ALLOWED = {"vision/compiled.py": {"pathlib"}}  # where the compiler keeps its machine code
FILES = [path for floor in FLOORS for path in sorted((ROOT / floor).rglob("*.py"))]


def imported_modules(tree: ast.AST) -> set[str]:
    """Top names of all absolute imports, also those inside functions."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_point_left_and_touch_only_what_they_may(path: Path) -> None:
    floor = path.relative_to(ROOT).parts[0]
    modules = imported_modules(ast.parse(path.read_text()))
    rightward = modules & set(FLOORS[FLOORS.index(floor) + 1 :])
    assert not rightward, f"{floor} may not import {rightward}"
    allowed = ALLOWED.get(path.relative_to(ROOT).as_posix(), set())
    assert not (modules & BANNED.get(floor, set())) - allowed


def test_no_relative_imports_hide_a_direction() -> None:
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text())):
            assert not (isinstance(node, ast.ImportFrom) and node.level), path


def test_only_recorded_files_know_the_file_formats() -> None:
    for path in FILES:
        if path.relative_to(ROOT).parts[0] == "pipeline":
            assert "mcap" not in imported_modules(ast.parse(path.read_text())), path
