"""A video file as a live camera: paced by its own times, newest first, with an end."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from pipeline.cameras.file import FileCamera
from pipeline.cameras.open import open_camera
from pipeline.clock import MonotonicClock, VirtualClock
from pipeline.errors import CameraError, ConfigError
from pipeline.ports import EndOfStream

TIMES = (0.0, 0.1, 0.2, 0.35, 0.4)  # s, uneven on purpose


@pytest.fixture
def video(tmp_path: Path) -> str:
    path = str(tmp_path / "uneven.mkv")
    with av.open(path, "w") as container:
        stream = container.add_stream("ffv1", rate=30)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "bgr0"
        stream.time_base = stream.codec_context.time_base = Fraction(1, 1000)
        for number, t in enumerate(TIMES):
            image = np.full((32, 48, 3), 40 * number, np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="bgr24")
            frame.pts, frame.time_base = round(1000 * t), Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def test_every_frame_comes_at_its_time_and_then_the_end(video: str) -> None:
    camera, clock = FileCamera(video, latency=0.03), VirtualClock()
    clock.wait_until(2.0)
    given: list[tuple[float, int, int]] = []
    while len(given) < len(TIMES):
        frame = camera.latest(clock.now())
        if frame is not None:
            assert -1e-6 < clock.now() - frame.t_capture - 0.03 < 0.005
            given.append((frame.t_capture, int(frame.image[0, 0, 0]), frame.sequence))
        clock.wait_until(clock.now() + 0.005)
    with pytest.raises(EndOfStream):
        camera.latest(clock.now())
    expected = [(2.0 + t, 40 * n, n) for n, t in enumerate(TIMES)]
    np.testing.assert_allclose(given, expected, atol=1e-9)
    camera.close()
    camera.close()


def test_the_newest_due_frame_wins(video: str) -> None:
    camera = FileCamera(video)
    assert camera.latest(1.0).sequence == 0  # type: ignore[union-attr]
    frame = camera.latest(1.36)
    assert frame is not None
    assert frame.sequence == 3
    assert frame.t_capture == pytest.approx(1.35)
    assert camera.report.dropped == 2
    assert camera.latest(1.37) is None


def test_what_is_no_video_is_one_clear_line(tmp_path: Path) -> None:
    text = tmp_path / "text.mp4"
    text.write_text("not a video at all")
    for path, words in ((str(text), "Invalid data"), (str(tmp_path), "is a folder")):
        with pytest.raises(CameraError, match=words):
            FileCamera(path)


@pytest.mark.parametrize(
    ("spec", "error", "words"),
    [
        ("99", CameraError, "/dev/video99: does not exist"),
        ("/dev/video99", CameraError, "/dev/video99: does not exist"),
        ("nowhere.mp4", CameraError, "nowhere.mp4: there is no such file"),
        ("http://127.0.0.1:9/x", CameraError, "Connection refused"),
        ("rtsp://127.0.0.1:9/x", CameraError, "Connection refused"),
        ("", ConfigError, "need rendered, an index"),
        ("webcam", ConfigError, "need rendered, an index"),
        ("-1", ConfigError, "need rendered, an index"),
        ("gopher://x", ConfigError, "need rendered, an index"),
    ],
)
def test_specs_that_cannot_be_opened(spec: str, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words) as caught:
        open_camera(spec, MonotonicClock())
    assert "\n" not in str(caught.value)


def test_a_file_spec_opens(video: str) -> None:
    camera = open_camera(video, VirtualClock())
    assert camera.latest(0.0) is not None
    camera.close()
