"""The doctor: every check sees what is wrong in a machine made of files, and says the remedy."""

import json
import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from pipeline.clock import MonotonicClock, VirtualClock
from pipeline.doctor import access, processor, room, software
from pipeline.doctor.beat import beat, lateness
from pipeline.doctor.machine import Machine
from pipeline.finding import Finding
from tests.pipeline.as_nobody import as_nobody
from tests.pipeline.commands import echelon_process


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    folders = [tmp_path / name for name in ("proc", "sys", "dev", "work")]
    for folder in folders:
        folder.mkdir()
    return Machine(*folders)


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "\n")


def judged(finding: Finding) -> str:
    """Its verdict; a remedy is given if and only if something is wrong."""
    assert bool(finding.remedy) == (finding.verdict != "fine")
    return finding.verdict


def test_a_machine_that_tells_nothing_is_not_called_bad(machine: Machine) -> None:
    silent = (
        room.usb(machine), room.udp_buffer(machine), processor.governor(machine),
        processor.clock_source(machine), processor.algebra_threads(None, 2),
    )  # fmt: skip
    assert {judged(finding) for finding in silent} == {"fine"}
    assert processor.openblas_threads(machine) is None


@pytest.mark.parametrize(
    ("governors", "verdict", "words"),
    [
        (("performance", "performance"), "fine", "2 x performance"),
        (("performance", "powersave"), "warning", "1 x performance, 1 x powersave"),
        (("schedutil",), "warning", "1 x schedutil"),
    ],
)
def test_governors(machine: Machine, governors: tuple[str, ...], verdict: str, words: str) -> None:
    for number, name in enumerate(governors):
        cpu = machine.sys / f"devices/system/cpu/cpu{number}"
        write(cpu / "cpufreq/scaling_governor", name)
    found = processor.governor(machine)
    assert (judged(found), found.detail) == (verdict, words)


def test_a_slow_clock_names_a_better_one(machine: Machine) -> None:
    folder = machine.sys / "devices/system/clocksource/clocksource0"
    write(folder / "available_clocksource", "hpet kvm-clock acpi_pm")
    for name, verdict in (("kvm-clock", "fine"), ("hpet", "warning")):
        write(folder / "current_clocksource", name)
        found = processor.clock_source(machine)
        assert (judged(found), found.detail) == (verdict, name)
    assert found.remedy.endswith("clocksource=kvm-clock")


def test_cores_and_threads() -> None:
    assert [judged(processor.cores(n)) for n in (1, 2, 8)] == ["warning", "fine", "fine"]
    assert judged(processor.algebra_threads(2, 2)) == "fine"
    assert judged(processor.algebra_threads(8, 2)) == "warning"


def test_the_algebra_of_this_process_tells_its_threads() -> None:
    np.linalg.inv(np.eye(3))  # it is loaded
    if "openblas" not in Path("/proc/self/maps").read_text():
        pytest.skip("NumPy uses another library here")
    threads = processor.openblas_threads(Machine())
    assert threads is not None
    assert threads >= 1


@pytest.mark.parametrize(("size", "verdict"), [("212992", "warning"), ("1048576", "fine")])
def test_udp_buffers(machine: Machine, size: str, verdict: str) -> None:
    write(machine.proc / "sys/net/core/rmem_max", size)
    assert judged(room.udp_buffer(machine)) == verdict


def plug(machine: Machine, bus: str, port: str, *nodes: str) -> None:
    """A USB camera with its device nodes, as sysfs lays them out."""
    interface = machine.sys / f"devices/pci0000:00/0000:00:14.0/{bus}/{port}/{port}:1.0"
    interface.mkdir(parents=True)
    for node in nodes:
        link = machine.sys / "class/video4linux" / node
        link.mkdir(parents=True)
        (link / "device").symlink_to(interface)


def test_cameras_that_share_a_slow_bus(machine: Machine) -> None:
    plug(machine, "usb1", "1-1", "video0", "video1")  # one camera, two nodes
    host = machine.sys / "devices/pci0000:00/0000:00:14.0"
    write(host / "usb1/speed", "480")
    assert judged(room.usb(machine)) == "fine"
    plug(machine, "usb2", "2-1", "video2")
    plug(machine, "usb2", "2-2", "video3")
    write(host / "usb2/speed", "5000")
    assert judged(room.usb(machine)) == "fine"
    plug(machine, "usb1", "1-4", "video4")
    found = room.usb(machine)
    assert judged(found) == "warning"
    assert found.detail == "usb1: 2 at 480 Mbit/s; usb2: 2 at 5000 Mbit/s"


@pytest.mark.parametrize(("gigabytes", "verdict"), [(100, "fine"), (10, "warning"), (1, "bad")])
def test_the_disk(
    machine: Machine, gigabytes: int, verdict: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Path] = []

    class Usage:
        free = gigabytes * 1_000_000_000

    def usage(folder: Path) -> type[Usage]:
        asked.append(folder)
        return Usage

    monkeypatch.setattr(room.shutil, "disk_usage", usage)  # nobody fills a disk for a test
    assert judged(room.disk(machine)) == verdict
    assert asked == [machine.work]


def test_the_disk_of_this_machine_is_read(machine: Machine) -> None:
    assert "GB free" in room.disk(machine).detail


@pytest.mark.parametrize("kind", ["cameras", "serial ports"])
def test_devices_that_the_user_may_not_open(kind: str) -> None:
    check, name = {
        "cameras": (access.cameras, "video0"),
        "serial ports": (access.serial_ports, "ttyUSB0"),
    }[kind]
    with TemporaryDirectory() as folder:  # not pytest's own, which nobody else may enter
        os.chmod(folder, 0o755)
        (Path(folder) / name).touch(mode=0o600)
        machine = Machine(dev=Path(folder))
        assert judged(check(machine)) == "fine"
        with as_nobody():
            found = check(machine)
    assert (judged(found), found.detail) == ("bad", f"not allowed: {name}")
    assert found.remedy.startswith("sudo usermod -aG ")


def test_who_will_not_be_allowed_is_warned(machine: Machine) -> None:
    assert judged(access.cameras(machine)) == ("fine" if os.geteuid() == 0 else "warning")


@pytest.mark.parametrize(
    ("found", "verdict"), [("3.10.12", "bad"), ("3.11.0", "fine"), ("3.14.0rc1", "fine")]
)
def test_python(found: str, verdict: str) -> None:
    assert judged(software.python(found, ">=3.11")) == verdict


def test_packages() -> None:
    wanted = ["numpy>=1.26", "numpy>=999", "no-such-package>=2", 'ruff>=999; extra == "dev"']
    assert [judged(finding) for finding in software.packages(wanted)] == ["bad", "bad"]
    assert [judged(finding) for finding in software.packages(wanted[:1])] == ["fine"]
    python, requirements = software.asked()
    assert python.startswith(">=")
    assert any(one.startswith("numpy") for one in requirements)


def test_strangers_and_viewer(tmp_path: Path) -> None:
    assert judged(software.strangers("")) == "fine"
    assert judged(software.strangers('the package "control" is ...')) == "bad"
    assert judged(software.viewer({"DISPLAY": ":0"}, tmp_path)) == "warning"
    (tmp_path / "rerun").touch()
    assert judged(software.viewer({"DISPLAY": ":0"}, tmp_path)) == "fine"
    assert judged(software.viewer({}, tmp_path)) == "warning"


@pytest.mark.parametrize(("late", "verdict"), [(0.5, "fine"), (2.0, "warning"), (6.0, "bad")])
def test_a_beat_that_is_late_now_and_then(late: float, verdict: str) -> None:
    waits = np.full(200, 5e-5)
    waits[:4] = 1e-3 * late  # two in a hundred
    assert judged(beat(waits)) == verdict


def test_a_perfect_clock_is_never_late() -> None:
    late = lateness(VirtualClock(), 0.01, 2.0)
    assert late.shape == (200,)
    assert np.abs(late).max() == 0.0
    assert lateness(MonotonicClock(), 0.01, 0.05).min() >= 0.0


@pytest.mark.realtime
def test_the_command_tells_findings_and_exits_by_the_worst() -> None:
    done = echelon_process("doctor", "--json")
    findings = json.loads(done.stdout)["findings"]
    assert {finding["topic"] for finding in findings} >= {"Python", "beat", "UDP buffer", "disk"}
    for finding in findings:
        assert set(finding) == {"topic", "found", "verdict", "remedy"}
        assert (finding["remedy"] is None) == (finding["verdict"] == "fine")
    bad = any(finding["verdict"] == "bad" for finding in findings)
    assert done.returncode == (2 if bad else 0)
