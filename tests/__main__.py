"""All tests: side by side, and then alone those that need real time.

    python -m tests [what pytest takes]

Both must pass. With a `-m` of one's own pytest runs once, as asked.
"""

import os
import subprocess
import sys
from time import monotonic

MOST = 4  # tests side by side; each has the vision's machine code and a world in memory
NOTHING = 5  # what pytest says if it found no test
SIDE_BY_SIDE, REAL_TIME = "side by side", "in real time"


def main(arguments: list[str]) -> int:
    """Run them.

    Args:
        arguments: which, as pytest takes them.

    Returns:
        The exit status: 0 if all that were found have passed.
    """
    if any(argument.startswith("-m") for argument in arguments):
        return _pytest(arguments)
    _compile()
    jobs = str(min(os.cpu_count() or 1, MOST))
    parts = {
        SIDE_BY_SIDE: ("-n", jobs, "--dist", "worksteal", "-m", "not realtime"),
        REAL_TIME: ("-m", "realtime"),
    }
    told, statuses = [], []
    for name, options in parts.items():
        start = monotonic()
        statuses.append(_pytest([*options, *arguments]))
        told.append(f"{name}: {_word(statuses[-1])}, {monotonic() - start:.0f} s")
    print("tests " + "; ".join(told))  # noqa: T201 (its output)
    return judged(statuses)


def judged(statuses: list[int]) -> int:
    """Judge several runs of pytest.

    Args:
        statuses: their exit statuses.

    Returns:
        0 if tests were found and all have passed, else the first status that says otherwise.
    """
    bad = [status for status in statuses if status not in (0, NOTHING)]
    return bad[0] if bad else min(statuses)


def _compile() -> None:
    """Compile vision and simulation, once and not in every process."""
    for command in ("check", "simulate"):
        subprocess.run(
            (sys.executable, "-m", "pipeline", command), stdout=subprocess.DEVNULL, check=True
        )


def _pytest(arguments: list[str]) -> int:
    return subprocess.run((sys.executable, "-m", "pytest", *arguments), check=False).returncode


def _word(status: int) -> str:
    return {0: "passed", NOTHING: "none of these"}.get(status, "FAILED")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
