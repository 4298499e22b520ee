"""Sessions: what is read is what was observed, whole or killed; damage is named."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

import datasets.session_writer as session_writer
from control.unicycle import UnicycleState
from datasets.cycle import Moment, RobotState, Tick
from datasets.errors import RecordingError
from datasets.recorded import (
    SessionHeader,
    SessionWriter,
    is_session,
    read_session,
    software_versions,
)
from datasets.session_codec import dumps, form
from datasets.session_format import decode_part, split
from tests.datasets.recorded_moments import moments
from vision.frame import as_frame
from vision.scene import Scene

HEADER = SessionHeader("paper", '{"robots": 3, "τ": 0.06}', 3, software_versions())


def equal(a: object, b: object) -> bool:
    """Same types of dataclass, same bits; arrays read-only."""
    if isinstance(a, np.ndarray):
        assert isinstance(b, np.ndarray)
        return a.dtype == b.dtype and np.array_equal(a, b) and not b.flags.writeable
    if is_dataclass(a):
        same = (equal(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
        return type(a) is type(b) and all(same)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(equal, a, b))
    return a == b and (not isinstance(a, float) or type(b) is float)


def record(path: Path, run: list[Moment]) -> Path:
    writer = SessionWriter(path, HEADER, lossless=True)
    for moment in run:
        writer.observe(moment)
    writer.close()
    writer.close()
    assert writer.dropped == 0
    return path


@pytest.fixture(scope="module")
def run() -> list[Moment]:
    return list(moments(1.2))


@pytest.fixture(scope="module")
def session(run: list[Moment], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("session") / "run.mcap", run)


def test_reads_back_what_was_observed(session: Path, run: list[Moment]) -> None:
    back = read_session(session)
    assert back.header == HEADER
    for _ in range(2):  # a session can be iterated again
        found = list(back)
        assert len(found) == len(run)
        assert all(map(equal, run, found))
        assert back.end.complete
        assert back.end.dropped == 0


def test_frames_are_there(session: Path) -> None:
    frames = [m.tick.frame for m in read_session(session) if m.tick.frame]
    assert [f.sequence for f in frames] == list(range(35))
    assert frames[0].size_px == (320, 240)
    assert not frames[0].image.flags.writeable


def test_other_programs_can_open_it(session: Path, run: list[Moment]) -> None:
    with session.open("rb") as stream:
        reader = make_reader(stream)  # by the index, as viewers do
        counts: dict[str, int] = {}
        for schema, channel, message in reader.iter_messages():
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
            assert schema is not None
            if channel.topic == "/camera":
                assert (schema.name, schema.encoding) == ("foxglove.CompressedImage", "protobuf")
                assert b"\x89PNG" in message.data
            else:
                assert schema.encoding == "jsonschema"
                json.loads(schema.data)
                assert json.loads(message.data)["t"] == pytest.approx(message.log_time * 1e-9)
    assert counts["/camera"] == 35
    assert counts["/inputs"] == counts["/timing"] == len(run)


def test_bounded_memory(session: Path) -> None:
    stream = iter(read_session(session))
    first = next(stream)
    assert first.tick.t == 0.0
    stream.close()


@given(value=st.floats(allow_nan=False), robot=st.integers(-(10**6), 10**6) | st.text(max_size=8))
def test_every_float_and_id_survives(value: float, robot: int | str) -> None:
    state = RobotState(robot, UnicycleState(value, -value, 0.1, 1e-300, 5e-324))
    plain = json.loads(dumps(form(RobotState).encode(state)))
    assert form(RobotState).decode(plain) == state


def test_not_a_number_survives() -> None:
    state = UnicycleState(float("nan"), float("inf"), 0.0, 0.0, 0.0)
    back = form(UnicycleState).decode(json.loads(dumps(form(UnicycleState).encode(state))))
    assert np.isnan(back.x)
    assert back.y == float("inf")


def test_unknown_type_is_refused() -> None:
    with pytest.raises(TypeError, match="no recorded form"):
        form(dict[str, int])


def test_negative_times_and_empty_scene(tmp_path: Path, run: list[Moment]) -> None:
    base = next(m for m in run if m.tick.frame)
    frame = as_frame(np.zeros((4, 6, 3), np.uint8), -2.5, 7, "früh")
    odd = replace(
        base,
        tick=replace(base.tick, t=-2.25, frame=frame, lost_links=("a", 2)),
        cycle=replace(base.cycle, t=-2.25, scene=Scene(-2.5, ()), planned=None, pairs=()),
        truth=(),
    )
    assert equal(odd, next(iter(read_session(record(tmp_path / "odd.mcap", [odd])))))


_VICTIM = """
import sys, time
from datasets.recorded import SessionHeader, SessionWriter
from tests.datasets.recorded_moments import moments
run = list(moments(1.2))
writer = SessionWriter(sys.argv[1], SessionHeader("x", "", 0, ()))
start = time.monotonic()
for moment in run:  # in real time
    time.sleep(max(0.0, start + moment.tick.t - time.monotonic()))
    writer.observe(moment)
    if moment.tick.frame:
        print(moment.tick.frame.sequence, time.monotonic(), flush=True)
time.sleep(60)
"""


@pytest.mark.realtime
def test_killed_recorder_keeps_all_but_the_last_half_second(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    environment = os.environ | {"PYTHONPATH": "."}
    command = [sys.executable, "-c", _VICTIM, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as victim:
        assert victim.stdout is not None
        seen = []
        for line in victim.stdout:
            number, observed = line.split()
            seen.append((int(number), float(observed)))
            if int(number) == 33:
                break
        killed = time.monotonic()
        victim.send_signal(signal.SIGKILL)
    session = read_session(path)
    kept = {m.tick.frame.sequence for m in session if m.tick.frame}
    due = {number for number, observed in seen if observed <= killed - 0.5}
    assert len(due) >= 15
    assert len(due & kept) >= 0.99 * len(due)
    assert not session.end.complete


def test_cut_anywhere_reads_the_moments_before(
    session: Path, run: list[Moment], tmp_path: Path
) -> None:
    data, cut = session.read_bytes(), tmp_path / "cut.mcap"
    for share in (0.3, 0.5001, 0.77, 0.999):
        cut.write_bytes(data[: int(share * len(data))])
        found = list(read_session(cut))
        assert len(found) > (share - 0.1) * 0.9 * len(run)
        assert all(map(equal, run, found))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "No such file"),
        (b"", "empty"),
        (b"RIFF....AVI " * 20, "not a session"),
        (b"\x89MCAP0\r\n", "no Echelon session"),
        (b"\x89MCAP", "no Echelon session"),
    ],
)
def test_unusable_files_are_named(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "bad.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RecordingError, match=f"bad.mcap.*{message}"):
        read_session(path)


def test_damage_inside_is_named(session: Path, tmp_path: Path) -> None:
    data = session.read_bytes().replace(b'"lost_links":[]', b'"lost_links":[}', 1)
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=r"damaged\.mcap: cycle 0, channel /inputs"):
        list(read_session(path))


def test_folder_and_unwritable_places(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="directory"):
        read_session(tmp_path)
    with pytest.raises(RecordingError, match="cannot be written"):
        SessionWriter(tmp_path / "missing" / "s.mcap", HEADER)


def test_is_session(session: Path, tmp_path: Path) -> None:
    assert is_session(session)
    assert not is_session(tmp_path / "nothing")
    assert not is_session(Path(__file__))


@pytest.mark.realtime
def test_real_time_drops_are_counted_and_written(
    tmp_path: Path, run: list[Moment], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that stalls: the loop is never held up, and the file says what it lacks."""
    monkeypatch.setattr(session_writer, "_REAL_TIME_MOMENTS", 10)
    go, pack = Event(), session_writer.pack_image
    monkeypatch.setattr(session_writer, "pack_image", lambda frame: (go.wait(10), pack(frame))[1])
    path = tmp_path / "slow.mcap"
    writer = SessionWriter(path, HEADER)
    for moment in run[:100]:
        writer.observe(moment)
    assert writer.dropped >= 70
    go.set()
    deadline = time.monotonic() + 10
    while writer._backlog._queue and time.monotonic() < deadline:
        time.sleep(0.005)
    writer.observe(run[100])
    writer.close()
    session = read_session(path)
    found = list(session)
    assert len(found) + writer.dropped == 101
    assert session.end.dropped == writer.dropped
    data = path.read_bytes()  # the count is also in the stream, for a file without an end
    path.write_bytes(data[: data.index(b"echelon.end")])
    assert list(session)
    assert session.end.dropped == writer.dropped
    assert not session.end.complete


def test_full_disk_is_reported_at_the_end(run: list[Moment]) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("needs /dev/full")
    with pytest.raises(RecordingError, match=r"/dev/full: .*space"):
        record(Path("/dev/full"), run[:50])


def test_what_an_older_session_does_not_know_takes_its_default() -> None:
    """Arrivals came later; a session recorded before them is read as ever."""
    frame = as_frame(np.zeros((4, 6, 3), np.uint8), 0.1, 3, "cam", 0.14, True)
    moment = replace(next(moments()), tick=Tick(0.2, frame))
    parts = dict(split(moment))
    inputs = json.loads(dumps(parts["/inputs"]))
    for key in ("t_arrival", "surely_new"):
        del inputs["inputs"]["frame"][key]
    stamp = decode_part("/inputs", inputs)["inputs"].frame
    assert (stamp.t_capture, stamp.t_arrival, stamp.surely_new) == (0.1, None, False)
    del inputs["inputs"]["frame"]["sequence"]
    with pytest.raises(KeyError):
        decode_part("/inputs", inputs)
