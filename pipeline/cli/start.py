"""The first thing `echelon` does: make sure that its packages are its own, then go on."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
INTERRUPTED = 130
PACKAGES = ("control", "vision", "datasets", "pipeline")


def main() -> None:
    """Refuse to run among foreign packages of the same names, else run the command line."""
    foreign = foreign_packages()
    if foreign:
        print(f"echelon: {foreign}", file=sys.stderr)  # noqa: T201 (the one line a user reads)
        sys.exit(2)
    os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")  # our errors say it in one line
    try:
        from pipeline.cli.main import main as run

        run()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def foreign_packages() -> str:
    """Look for other packages called `control` or `datasets` in front of Echelon's own.

    Returns:
        What was found and what to do, empty if all is well.
    """
    for name in PACKAGES:
        spec = find_spec(name)
        found = Path(spec.origin).resolve().parent if spec and spec.origin else None
        if found != HOME / name:
            return (
                f'the package "{name}" is not Echelon\'s but the one in {found}; '
                "install Echelon in an environment of its own (make install)"
            )
    return ""
