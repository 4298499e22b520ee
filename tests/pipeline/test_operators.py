"""Keys, signals and terminals: what people type becomes orders."""

import json
import os
import pty
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from time import monotonic, sleep

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.keyed import KeyDrive
from datasets.cycle import Moment, Orders
from datasets.recorded import read_session
from pipeline.errors import ConfigError
from pipeline.interruption import ARM, HALT, noted
from pipeline.operators.keys import HANDS_OFF, Keys
from pipeline.operators.nobody import Nobody
from pipeline.operators.signals import Signals
from pipeline.operators.terminal import Terminal
from pipeline.operators.together import Together
from tests.pipeline.commands import ECHELON, ROOT, echelon

DRIVE = KeyDrive(speed=0.5, turn=2.0, ramp=1.0)
UP, DOWN, RIGHT, LEFT = b"\x1b[A", b"\x1b[B", b"\x1b[C", b"\x1b[D"


def twist(orders: Orders) -> tuple[float, float]:
    assert orders.drive is not None
    return orders.drive.v, orders.drive.omega


def test_arrows_drive_in_steps_up_to_the_limits() -> None:
    keys = Keys(DRIVE)
    assert twist(keys.read(UP, 0.0)) == pytest.approx((0.1, 0.0))
    assert twist(keys.read(UP + LEFT, 0.1)) == pytest.approx((0.2, 0.4))
    assert twist(keys.read(9 * UP + 9 * LEFT, 0.2)) == pytest.approx((0.5, 2.0))
    assert twist(keys.read(6 * DOWN + 12 * RIGHT, 0.3)) == pytest.approx((-0.1, -2.0))
    assert twist(keys.read(b"s", 0.4)) == (0.0, 0.0)


def test_a_halt_stands_and_comes_before_an_arming() -> None:
    keys = Keys(DRIVE)
    keys.read(UP, 0.0)
    orders = keys.read(b"r r", 0.1)
    assert (orders.halt, orders.arm, twist(orders)) == (True, False, (0.0, 0.0))
    assert keys.read(b"r", 0.2) == Orders(keys.read(b"", 0.2).drive, arm=True)
    assert keys.read(b"c", 0.3).report


def test_without_hands_the_leader_stands() -> None:
    keys = Keys(DRIVE)
    keys.read(UP, 0.0)
    assert twist(keys.read(b"", HANDS_OFF)) != (0.0, 0.0)
    assert twist(keys.read(b"", HANDS_OFF + 0.01)) == (0.0, 0.0)


def test_an_arrow_may_come_in_pieces_and_escape_is_no_trap() -> None:
    keys = Keys(DRIVE)
    for piece in (b"\x1b", b"[", b"A"):
        orders = keys.read(piece, 0.0)
    assert twist(orders) == pytest.approx((0.1, 0.0))
    assert keys.read(b"\x1b", 0.1).halt is False
    assert keys.read(b" ", 0.2).halt is True


@given(st.lists(st.binary(max_size=20), max_size=30), st.booleans())
def test_any_bytes_are_keys_within_limits(pieces: list[bytes], drives: bool) -> None:
    keys = Keys(DRIVE if drives else None)
    for n, piece in enumerate(pieces):
        orders = keys.read(piece, 0.1 * n)
        assert (orders.drive is not None) == drives
        assert orders.halt == (b" " in piece)
        if orders.drive is not None:
            assert abs(orders.drive.v) <= 0.5 + 1e-12
            assert abs(orders.drive.omega) <= 2.0 + 1e-12


def test_signals_stop_and_arm_and_are_given_back() -> None:
    before = signal.getsignal(signal.SIGUSR1)
    with noted((HALT, ARM)) as came:
        both = Together((Nobody(), Signals(came)))
        assert both.orders(0.0) == Orders()
        signal.raise_signal(signal.SIGUSR2)
        assert both.orders(0.1) == Orders(arm=True)
        signal.raise_signal(signal.SIGUSR2)
        signal.raise_signal(signal.SIGUSR1)
        assert both.orders(0.2) == Orders(halt=True)
        assert both.orders(0.3) == Orders()
        both.close()
        signal.raise_signal(signal.SIGUSR1)  # after the run it ends nothing
    assert signal.getsignal(signal.SIGUSR1) == before


def test_a_terminal_is_given_back_as_it_was() -> None:
    import termios

    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    terminal = Terminal(DRIVE, slave)
    assert not termios.tcgetattr(slave)[3] & termios.ECHO
    os.write(master, UP)
    sleep(0.05)
    assert twist(terminal.orders(0.0)) == pytest.approx((0.1, 0.0))
    terminal.close()
    terminal.close()
    assert termios.tcgetattr(slave) == before
    os.close(master)
    os.close(slave)
    with pytest.raises(ConfigError, match="need a terminal"):
        Terminal(DRIVE, os.open(os.devnull, os.O_RDONLY))


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux's /proc")
def test_a_stop_during_the_set_up_counts_from_the_first_cycle() -> None:
    command = (*ECHELON, "live", "paper", "--duration", "1", "--fast", "--json")
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    while not catches(process.pid, signal.SIGUSR1):
        assert process.poll() is None
        sleep(0.001)
    process.send_signal(signal.SIGUSR1)
    result = json.loads(process.communicate(timeout=60.0)[0])
    assert process.returncode == 0
    assert [event["kind"] for event in result["safety_events"]] == ["emergency-stop"]
    assert result["safety_events"][0]["t"] == 0.0
    assert result["frames"] > 20
    assert result["leader"] is None  # the mission has not begun


def catches(pid: int, number: int) -> bool:
    """Whether a process has a handler of a signal."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    mask = next(line.split()[1] for line in lines if line.startswith("SigCgt"))
    return bool(int(mask, 16) >> (number - 1) & 1)


BACKGROUND = """
import os, pty, sys
master, slave = pty.openpty()
os.setsid()
os.close(os.open(os.ttyname(slave), os.O_RDWR))  # the first one becomes its terminal
os.dup2(slave, 0), os.dup2(slave, 2)
from pipeline.operators.terminal import there_is_a_terminal
assert there_is_a_terminal()
if os.fork() == 0:
    os.setpgid(0, 0)  # as a shell does with a job behind others
    os._exit(there_is_a_terminal())
sys.exit(os.waitstatus_to_exitcode(os.wait()[1]))
"""


def test_a_program_in_the_background_leaves_the_terminal_alone() -> None:
    done = subprocess.run(
        (sys.executable, "-c", BACKGROUND), start_new_session=False, timeout=60, check=False
    )
    assert done.returncode == 0


def test_keys_without_a_terminal_are_refused() -> None:
    done = echelon("live", "paper", "--set", "leader.driven_by=keys", "--fast")
    assert done.returncode == 2
    assert "needs a terminal" in done.stderr


class Typist:
    """`echelon live` on a terminal of its own."""

    def __init__(self, *arguments: object) -> None:
        self.master, slave = pty.openpty()
        command = (sys.executable, "-m", "pipeline", *map(str, arguments))
        self.process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave)
        os.close(slave)
        self.said = ""
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        try:
            while data := os.read(self.master, 4096):
                self.said += data.decode(errors="replace")
        except OSError:  # the program has ended
            return

    def wait_for(self, text: str, timeout: float = 60.0) -> None:
        """Wait until it has said something."""
        self.wait(lambda: text in self.said, timeout)

    def wait(self, holds: Callable[[], bool], timeout: float = 60.0) -> None:
        end = monotonic() + timeout
        while not holds():
            assert monotonic() < end, self.said
            sleep(0.02)

    def close(self) -> None:
        """End it, whatever it does."""
        self.process.kill()
        self.process.wait(10.0)
        os.close(self.master)

    def type(self, keys: bytes) -> None:
        os.write(self.master, keys)


@pytest.mark.realtime
def test_a_person_drives_the_leader_stops_it_and_arms_it_again(tmp_path: Path) -> None:
    session = tmp_path / "keys.mcap"
    keyed = ("--set", "leader.driven_by=keys", "--set", "duration_s=60")
    with closing(Typist("live", "paper", "--hold", *keyed, "--record", session)) as typist:
        drive(typist)
    check_course(list(read_session(session)))
    done = echelon("replay", session, "--compare", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["leader"] is None


def drive(typist: Typist) -> None:
    """Arm, drive, stop, arm and drive again; then what Ctrl-C sends."""
    typist.wait_for("nothing moves before r")
    typist.wait_for("idle -> armed")
    sleep(0.5)
    typist.type(b"r")
    typist.wait_for("armed -> running")
    typist.type(UP + UP + LEFT)
    sleep(1.5)
    typist.type(b" ")
    typist.wait_for("running -> stopped")
    sleep(0.5)
    typist.type(b"r" + UP)
    sleep(1.0)
    typist.process.send_signal(signal.SIGINT)
    assert typist.process.wait(30.0) == 130


def check_course(moments: list[Moment]) -> None:
    """Driven as wanted, stopped in the very cycle, and driven again."""
    halt = next(n for n, m in enumerate(moments) if m.tick.orders.halt)
    arm = next(n for n in range(halt, len(moments)) if moments[n].tick.orders.arm)
    fastest = max(r.state.v for m in moments[:halt] for r in m.truth if r.robot_id == 1)
    assert fastest == pytest.approx(0.2, abs=0.03)
    for moment in moments[halt:arm]:
        assert moment.cycle.phase == "stopped"
        assert all(c.twist.v == c.twist.omega == 0.0 for c in moment.cycle.commands)
        assert len(moment.cycle.commands) == 3
    still = [abs(r.state.v) for r in moments[arm].truth]
    assert max(still) < 0.005
    assert any(abs(c.twist.v) > 0.01 for m in moments[arm + 5 :] for c in m.cycle.commands)
    kinds = [event.kind for m in moments for event in m.cycle.events]
    assert kinds.count("emergency-stop") == kinds.count("armed") == 1
