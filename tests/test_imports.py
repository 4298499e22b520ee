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
UNSETTABLE = {"monotonic", "perf_counter", "sleep"}  # what control may know of time
TELLS_THE_TIME = {"pipeline/publishers/ssl_vision.py"}  # SSL-Vision's times are since 1970
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


def test_nothing_reads_a_clock_that_can_be_set_but_to_tell_other_programs() -> None:
    for path in FILES:
        tree = ast.parse(path.read_text())
        read = names_of_time(tree) - UNSETTABLE
        assert not read or path.relative_to(ROOT).as_posix() in TELLS_THE_TIME, (path, read)
        assert "datetime" not in imported_modules(tree), path


def names_of_time(tree: ast.AST) -> set[str]:
    """What is taken from the module `time`, by either kind of import."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == "time":
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found |= {node.attr} if node.value.id == "time" else set()
    return found
