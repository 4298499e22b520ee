"""The command line as a user meets it: a process of its own."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
ECHELON = [sys.executable, "-m", "pipeline"]


def echelon(*arguments: object, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """Run `echelon` to its end."""
    command = [*ECHELON, *map(str, arguments)]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False
    )
