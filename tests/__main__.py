"""All tests: those that need real time with the others behind them, then those that need it alone.

    python -m tests [what pytest takes]

All must pass. With a `-m` of one's own pytest runs once, as asked.
"""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from time import monotonic

MOST = 4  # tests side by side; each has the vision's machine code and a world in memory
NOTHING = 5  # what pytest says if it found no test
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # in each of those side by side: they share the cores
REAL_TIME, ALONE = ("-m", "realtime and not alone"), ("-m", "alone")


def main(arguments: list[str]) -> int:
    """Run them.

    Args:
        arguments: which, as pytest takes them.

    Returns:
        The exit status: 0 if all that were found have passed.
    """
    if any(argument.startswith("-m") for argument in arguments):
        return subprocess.run(_pytest(arguments), check=False).returncode
    _compile()
    jobs = str(min(os.cpu_count() or 1, MOST))
    many = ("-n", jobs, "--dist", "worksteal", "-m", "not (realtime or alone)")
    with ThreadPoolExecutor(1) as behind:
        others = behind.submit(_told, "side by side", [*many, *arguments], gives_way=True)
        statuses = {"in real time": _told("in real time", [*REAL_TIME, *arguments])}
        statuses["side by side"] = others.result()
    statuses["alone"] = _told("alone", [*ALONE, *arguments])
    said = (f"{name}: {_word(status)}" for name, status in statuses.items())
    print(*said, sep="; ")  # noqa: T201 (its output)
    return judged(list(statuses.values()))


def judged(statuses: list[int]) -> int:
    """Judge several runs of pytest.

    Args:
        statuses: their exit statuses.

    Returns:
        0 if tests were found and all have passed, else the first status that says otherwise.
    """
    bad = [status for status in statuses if status not in (0, NOTHING)]
    return bad[0] if bad else min(statuses)


def _told(name: str, arguments: list[str], gives_way: bool = False) -> int:
    """Run pytest, each line of its output with a name before it."""
    start, say = monotonic(), partial(print, f"{name}:", flush=True)
    with subprocess.Popen(
        _pytest(arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ | (ONE_THREAD if gives_way else {}),
        preexec_fn=_give_way if gives_way else None,
    ) as process:  # fmt: skip
        for line in process.stdout or ():
            say(line.rstrip("\n"))
    status = process.returncode
    say(f"{_word(status)}, {monotonic() - start:.0f} s")
    return status


def _give_way() -> None:
    """Run only while no other process wants the processor, as do all processes begun from here."""
    os.nice(19)
    with suppress(AttributeError, OSError):  # not everywhere, and not always allowed
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def _compile() -> None:
    """Compile vision and simulation, once and not in every process."""
    for command in ("check", "simulate"):
        subprocess.run(
            (sys.executable, "-m", "pipeline", command), stdout=subprocess.DEVNULL, check=True
        )


def _pytest(arguments: list[str]) -> list[str]:
    return [sys.executable, "-m", "pytest", *arguments]


def _word(status: int) -> str:
    return {0: "passed", NOTHING: "none of these"}.get(status, "FAILED")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
