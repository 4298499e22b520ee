"""The software: Python, packages, strangers among them, the viewer."""

import sys
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from pipeline.finding import Finding

PACKAGE = "echelon-formation"
INSTALL = "make install"


def python(found: str, wanted: str) -> Finding:
    """Compare Python's version with what is asked.

    Args:
        found: e.g. 3.11.7.
        wanted: e.g. >=3.11.

    Returns:
        Bad if it is too old.
    """
    fits = SpecifierSet(wanted).contains(found, prereleases=True)
    remedy = "" if fits else f"{INSTALL} PYTHON=python3.12"
    return Finding("Python", fits, f"{found}, {wanted} is asked", remedy=remedy)


def packages(wanted: Iterable[str]) -> Iterator[Finding]:
    """Compare installed packages with what is asked.

    Args:
        wanted: requirements as pyproject.toml writes them; those of extras are left out.

    Yields:
        One bad finding for each that does not fit; a fine one if all do.
    """
    needed = [one for one in map(Requirement, wanted) if one.marker is None]
    wrong = [finding for one in needed if (finding := _unfit(one)) is not None]
    yield from wrong
    if not wrong:
        names = ", ".join(f"{one.name} {version(one.name)}" for one in needed)
        yield Finding("packages", True, names)


def strangers(foreign: str) -> Finding:
    """Whether packages of other people answer to the names of Echelon's own.

    Args:
        foreign: what was found at start, empty if all is well.

    Returns:
        Bad if there are any.
    """
    if foreign:
        return Finding("foreign packages", False, foreign, remedy=INSTALL)
    return Finding("foreign packages", True, "none called control, vision, datasets or pipeline")


def viewer(environment: Mapping[str, str], folder: Path) -> Finding:
    """Whether `--view rerun` can show something.

    Args:
        environment: of the process.
        folder: of the programs of this Python.

    Returns:
        A warning without the viewer or a screen.
    """
    keep = "keep the view instead: --view FILE.rrd"
    if not any((folder / name).is_file() for name in ("rerun", "rerun.exe")):
        return Finding("viewer", False, f"no rerun in {folder}", False, f"{INSTALL}; or {keep}")
    screen = sys.platform != "linux" or any(
        environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )
    if not screen:
        return Finding("viewer", False, "rerun is here, but no screen", False, keep)
    return Finding("viewer", True, "rerun and a screen are here")


def asked() -> tuple[str, list[str]]:
    """What the installed package asks for.

    Returns:
        Versions of Python, and requirements; empty where it is not installed.
    """
    try:
        return metadata(PACKAGE)["Requires-Python"] or "", requires(PACKAGE) or []
    except PackageNotFoundError:
        return "", []


def _unfit(wanted: Requirement) -> Finding | None:
    topic, remedy = f"package {wanted.name}", INSTALL
    try:
        found = version(wanted.name)
    except PackageNotFoundError:
        return Finding(topic, False, f"missing, {wanted.specifier} is asked", remedy=remedy)
    if wanted.specifier.contains(found, prereleases=True):
        return None
    return Finding(topic, False, f"{found}, {wanted.specifier} is asked", remedy=remedy)
