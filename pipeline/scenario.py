"""Reading scenario files: names, includes, overrides, and errors that name file, line and key."""

import difflib
import re
import tomllib
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pipeline.config import Scenario
from pipeline.errors import ConfigError

Table = dict[str, Any]
_HEADER = re.compile(r"^\s*\[{1,2}\s*([^\]]+?)\s*\]{1,2}")
_KEY = re.compile(r"^\s*([A-Za-z0-9_\-]+)\s*=")
_NAMES = {"robots": "id", "pairs": "follower"}  # what a member of a list is called by in --set


def load_scenario(name: str, overrides: Sequence[str] = ()) -> Scenario:
    """Read a scenario and check it.

    Args:
        name: of a shipped scenario, or the path of a TOML file.
        overrides: "section.key=value" texts; a list's member is named by its id, e.g.
            "robots.2.lag_s=0.06".

    Returns:
        The checked scenario.

    Raises:
        ConfigError: naming file, line, key and the nearest right key.
    """
    path = scenario_path(name)
    table, sources = _read(path)
    return _checked(table, sources, overrides)


def check_tables(table: Table, source: str, overrides: Sequence[str] = ()) -> Scenario:
    """Check a scenario that is in no file.

    Args:
        table: as a file would hold it; overrides are laid over it.
        source: what an error names instead of a file.
        overrides: "section.key=value" texts.

    Returns:
        The checked scenario.

    Raises:
        ConfigError: naming the source, the key and the nearest right key.
    """
    return _checked(table, {Path(source): ""}, overrides)


def parse_scenario(json_text: str) -> Scenario:
    """Rebuild a scenario that a session carries.

    Args:
        json_text: what `Scenario.model_dump_json` wrote.

    Returns:
        The same scenario.

    Raises:
        ConfigError: if the text is not a scenario of this version.
    """
    try:
        return Scenario.model_validate_json(json_text)
    except ValidationError as error:
        raise ConfigError(f"the session's scenario: {error.errors()[0]['msg']}") from None


def scenario_names() -> list[str]:
    """Names of the shipped scenarios, sorted.

    Returns:
        Names without the file ending.
    """
    folder = resources.files("datasets") / "scenarios"
    return sorted(
        f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")
    )


def scenario_path(name: str) -> Path:
    """Find the file of a scenario.

    Args:
        name: shipped name or path.

    Returns:
        An existing file.

    Raises:
        ConfigError: if there is none, naming the nearest shipped scenario.
    """
    path = Path(name)
    if path.suffix == ".toml" or path.is_file():
        if path.is_file():
            return path
        raise ConfigError(f"{name}: no such file")
    names = scenario_names()
    if name in names:
        return Path(str(resources.files("datasets") / "scenarios" / f"{name}.toml"))
    raise ConfigError(f'no scenario "{name}"{_nearest(name, names)}; there are: {", ".join(names)}')


def _checked(table: Table, sources: dict[Path, str], overrides: Sequence[str]) -> Scenario:
    """The scenario of a table with overrides laid over it."""
    for text in overrides:
        _override(table, text)
    try:
        return Scenario.model_validate(table)
    except ValidationError as error:
        raise ConfigError(_explain(_telling(error.errors()), sources, overrides)) from None


def _read(path: Path, seen: tuple[Path, ...] = ()) -> tuple[Table, dict[Path, str]]:
    """The tables of a file and of what it includes, with the text of each."""
    if path.resolve() in seen:
        raise ConfigError(f"{path}: includes itself")
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from None
    sources: dict[Path, str] = {}
    merged: Table = {}
    for name in table.pop("include", []):
        part, texts = _read(path.parent / str(name), (*seen, path.resolve()))
        _merge(merged, part)
        sources |= texts
    _merge(merged, table)
    return merged, sources | {path: text}


def _merge(into: Table, table: Table) -> None:
    """Lay a table over another; sub-tables are merged, everything else is replaced."""
    for key, value in table.items():
        if isinstance(value, dict) and isinstance(into.get(key), dict):
            _merge(into[key], value)
        else:
            into[key] = value


def _override(table: Table, text: str) -> None:
    """Lay one "section.key=value" over the tables."""
    path, equals, value = text.partition("=")
    keys = path.strip().split(".")
    if not equals or not all(keys):
        raise ConfigError(f'--set {text}: need "section.key=value"')
    nodes: list[Any] = [table]
    for key, parent in zip(keys[:-1], ["", *keys], strict=False):
        nodes = [below for node in nodes for below in _descend(node, key, parent, text)]
    for node in nodes:
        if not isinstance(node, dict):
            raise ConfigError(f"--set {text}: {'.'.join(keys[:-1])} has no keys")
        node[keys[-1]] = _value(value.strip())


def _descend(node: Any, key: str, parent: str, text: str) -> list[Any]:
    """One step down a path; the members of a list go by their id, all of them by a star."""
    if isinstance(node, dict):
        return [node.setdefault(key, {})]
    if isinstance(node, list):
        name = _NAMES.get(parent, "id")
        named = [m for m in node if isinstance(m, dict) and key in (str(m.get(name)), "*")]
        if named:
            return named
        raise ConfigError(f'--set {text}: no member of {parent} with {name} "{key}"')
    raise ConfigError(f"--set {text}: {parent} has no keys")


def _value(text: str) -> Any:
    """A TOML value, or the text itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _telling(errors: Sequence[ErrorDetails]) -> ErrorDetails:
    """The error that says most: an unknown key before a missing one, deep before shallow."""
    return min(errors, key=lambda e: (e["type"] != "extra_forbidden", -len(e["loc"])))


def _explain(error: ErrorDetails, sources: Mapping[Path, str], overrides: Sequence[str]) -> str:
    """One line: place, key, what is wrong, what may have been meant."""
    keys = [part for part in error["loc"] if not _is_branch(part)]
    place = _place(keys, sources, overrides)
    name = ".".join(str(key) for key in keys) or "the scenario"
    if error["type"] == "extra_forbidden":
        return f'{place}unknown key "{name}"{_nearest(str(keys[-1]), _known_keys(keys[:-1]))}'
    if error["type"] == "missing":
        return f'{place}missing key "{name}"'
    message = error["msg"].removeprefix("Value error, ")
    given = "" if error["type"] == "value_error" else f", not {error['input']!r}"
    return f"{place}{name}: {message[0].lower()}{message[1:]}{given}"


def _is_branch(part: int | str) -> bool:
    """Whether a step of an error's path names a type of a union, not a key."""
    return isinstance(part, str) and not re.fullmatch(r"[a-z][a-z0-9_]*", part)


def _known_keys(path: Sequence[int | str]) -> list[str]:
    """The keys a section takes."""
    model: Any = Scenario
    for key in path:
        if isinstance(key, str) and key in getattr(model, "model_fields", {}):
            model = _section_in(model.model_fields[key].annotation)
    return list(getattr(model, "model_fields", {}))


def _section_in(annotation: Any) -> Any:
    """The section class inside an annotation such as `tuple[RobotConfig, ...]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_section_in(part) for part in getattr(annotation, "__args__", ()))
    return next((part for part in found if part is not None), None)


def _nearest(name: str, names: Sequence[str]) -> str:
    """A hint at what may have been meant, or nothing."""
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f'; did you mean "{close[0]}"?' if close else ""


def _place(keys: Sequence[int | str], sources: Mapping[Path, str], overrides: Sequence[str]) -> str:
    """The file and line of a key, or the option that set it."""
    words = [str(key) for key in keys if isinstance(key, str)]
    for text in overrides:
        if words and text.split("=")[0].split(".")[-1] == words[-1]:
            return f"--set {text}: "
    for path, text in reversed(list(sources.items())):
        line = _line_of(keys, text)
        if line:
            return f"{path}:{line}: "
    return f"{list(sources)[-1]}: "


def _line_of(keys: Sequence[int | str], text: str) -> int:
    """The line on which a key is set, or its section's header; 0 if there is neither."""
    section: list[str] = []
    counts: dict[str, int] = {}
    best, best_depth = 0, 0
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            name = header.group(1)
            counts[name] = counts.get(name, -1) + 1
            section = name.split(".")
            found = section + ([str(counts[name])] if line.lstrip().startswith("[[") else [])
        elif key := _KEY.match(line):
            found = [
                *section,
                *([str(counts[".".join(section)])] if _is_list(section, keys) else []),
                key.group(1),
            ]
        else:
            continue
        depth = _agreement(found, [str(key) for key in keys])
        if depth > best_depth:
            best, best_depth = number, depth
    return best


def _is_list(section: Sequence[str], keys: Sequence[int | str]) -> bool:
    """Whether the section at the head of a path is a list there."""
    return bool(section) and len(keys) > len(section) and isinstance(keys[len(section)], int)


def _agreement(found: Sequence[str], wanted: Sequence[str]) -> int:
    """How deep a path of the file leads to the wanted key; 0 if it leads elsewhere."""
    return len(found) if list(wanted[: len(found)]) == list(found) else 0
