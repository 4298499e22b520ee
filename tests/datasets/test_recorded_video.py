"""Videos, folders and images: every pixel and time stamp, and every way a file can be unusable."""

import json
import os
from math import degrees, pi
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from control.geometry import Pose2D
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.errors import RecordingError
from datasets.recorded import TruthWriter, VideoWriter, read_frames, read_image
from tests.datasets.recorded_moments import camera
from vision.frame import Frame, as_frame

REAL = Path(os.environ.get("ECHELON_REAL_FRAMES", "../shared/real"))
real = pytest.mark.skipif(not REAL.is_dir(), reason=f"no real frames in {REAL}")


def noisy_frames(count: int, width: int = 62, height: int = 47) -> list[Frame]:
    """Odd sizes, uneven times: nothing a codec could keep by luck."""
    random = np.random.default_rng(1)
    images = random.integers(0, 256, (count, height, width, 3), np.uint8)
    return [as_frame(image, 3.0 + i * 0.04 + 0.001 * (i % 3), i) for i, image in enumerate(images)]


def write(path: Path, frames: list[Frame]) -> Path:
    writer = VideoWriter(path, 25.0)
    for frame in frames:
        writer.write(frame)
    writer.close()
    writer.close()
    return path


@pytest.mark.parametrize("suffix", [".mp4", ".mov", ".mkv", ".avi"])
def test_video_is_lossless(tmp_path: Path, suffix: str) -> None:
    frames = noisy_frames(12)
    back = list(read_frames(write(tmp_path / f"v{suffix}", frames)))
    assert len(back) == 12
    for one, other in zip(frames, back, strict=True):
        assert np.array_equal(one.image, other.image)
        assert one.sequence == other.sequence
    times = [frame.t_capture for frame in back]
    tolerance = 0.04 if suffix == ".avi" else 0.0006  # s; AVI knows frame numbers only
    assert times == pytest.approx([f.t_capture - 3.0 for f in frames], abs=tolerance)
    assert all(np.diff(times) > 0)


def test_rate_given_by_hand_replaces_time_stamps(tmp_path: Path) -> None:
    footage = read_frames(write(tmp_path / "v.mkv", noisy_frames(4)), fps=10.0)
    assert [f.t_capture for f in footage] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert len(list(footage)) == 4  # again


def test_raw_stream_without_time_stamps(tmp_path: Path) -> None:
    path = tmp_path / "raw.h264"
    with av.open(str(path), "w", format="h264") as out:
        stream = out.add_stream("libx264", rate=20)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for frame in noisy_frames(6, 64, 48):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(frame.image, format="bgr24")))
        out.mux(stream.encode(None))
    times = [f.t_capture for f in read_frames(path)]
    assert len(times) == 6
    assert all(np.diff(times) > 0)


@pytest.mark.parametrize("suffix", [".mkv", ".avi", ".mov"])
def test_truncated_video_gives_its_beginning_and_counts_the_rest(
    tmp_path: Path, suffix: str
) -> None:
    frames = noisy_frames(40)
    path = write(tmp_path / f"v{suffix}", frames)
    data = path.read_bytes()
    if suffix == ".mov":  # its index is at the end: move it to the front, as servers do
        with (
            av.open(str(path)) as source,
            av.open(str(tmp_path / "f.mov"), "w", options={"movflags": "faststart"}) as target,
        ):
            stream = target.add_stream_from_template(source.streams.video[0])
            for packet in source.demux(video=0):
                if packet.dts is not None:
                    packet.stream = stream
                    target.mux(packet)
        data = (tmp_path / "f.mov").read_bytes()
    path.write_bytes(data[: len(data) // 2])
    footage = read_frames(path)
    found = list(footage)
    assert 15 <= len(found) <= 21
    whole = [np.array_equal(a.image, b.image) for a, b in zip(frames, found, strict=False)]
    assert all(whole[:-1])
    assert footage.lost >= 40 - len(found) - 2


def test_video_cut_in_its_index_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "v.mp4", noisy_frames(10))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(RecordingError, match=r"v\.mp4.*not a readable video"):
        read_frames(path)


def test_unusable_sources_are_named(tmp_path: Path) -> None:
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "text.mp4").write_text("no video " * 99)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "notes.txt").touch()
    for name, message in (
        ("missing.mp4", "no such file"),
        ("empty.mp4", "empty"),
        ("text.mp4", "not a readable video"),
        ("folder", "no images"),
    ):
        with pytest.raises(RecordingError, match=f"{name}.*{message}"):
            read_frames(tmp_path / name)
    with pytest.raises(RecordingError, match="frame rate"):
        read_frames(tmp_path, fps=0.0)


def test_sound_without_pictures_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "beep.wav"
    with av.open(str(path), "w") as out:
        stream = out.add_stream("pcm_s16le", rate=8000)
        sound = av.AudioFrame.from_ndarray(np.zeros((1, 800), np.int16), layout="mono")
        sound.sample_rate = 8000
        out.mux(stream.encode(sound))
    with pytest.raises(RecordingError, match="no video stream"):
        read_frames(path)


def test_folder_in_natural_order(tmp_path: Path) -> None:
    for number in (10, 2, 1):
        cv2.imwrite(str(tmp_path / f"image{number}.png"), np.full((3, 5, 3), number, np.uint8))
    (tmp_path / ".hidden.png").touch()
    frames = list(read_frames(tmp_path))
    assert [int(f.image[0, 0, 0]) for f in frames] == [1, 2, 10]
    assert [f.t_capture for f in frames] == pytest.approx([0, 1 / 30, 2 / 30])
    assert frames[0].size_px == (5, 3)


def test_images_of_every_kind(tmp_path: Path) -> None:
    def kept(name: str, image: np.ndarray) -> np.ndarray:
        cv2.imwrite(str(tmp_path / name), image)
        back = read_image(tmp_path / name)
        assert back.dtype == np.uint8
        assert back.shape == (3, 5, 3)
        return back

    color = np.random.default_rng(0).integers(0, 256, (3, 5, 3), np.uint8)
    assert np.array_equal(kept("color.png", color), color)
    assert np.array_equal(kept("color.bmp", color), color)
    assert np.array_equal(kept("grey.png", color[:, :, 0])[:, :, 2], color[:, :, 0])
    assert np.array_equal(kept("deep.png", color.astype(np.uint16) * 257), color)
    assert np.array_equal(
        kept("deepgrey.png", color[:, :, 1].astype(np.uint16) * 257)[:, :, 0], color[:, :, 1]
    )
    opaque = np.dstack((color, np.full((3, 5), 255, np.uint8)))
    assert np.array_equal(kept("alpha.png", opaque), color)
    assert not kept("clear.png", opaque * np.array([1, 1, 1, 0], np.uint8)).any()
    assert kept("grey.jpg", np.full((3, 5), 90, np.uint8))[0, 0].tolist() == [90, 90, 90]


def test_damaged_image_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"not a picture")
    with pytest.raises(RecordingError, match=r"a\.png: is not an image"):
        list(read_frames(tmp_path))
    with pytest.raises(RecordingError, match=r"b\.png: cannot be read"):
        read_image(tmp_path / "b.png")
    (tmp_path / "c.png").touch()
    with pytest.raises(RecordingError, match=r"c\.png: the file is empty"):
        read_image(tmp_path / "c.png")


@pytest.mark.parametrize("name", ["out", "out.mkv"])
def test_truth_beside_the_frames(tmp_path: Path, name: str) -> None:
    eye, pose = camera(), Pose2D(0.3, 0.2, 0.7)
    state = UnicycleState(pose.x, pose.y, pose.theta + 2 * pi, 0.5, 0.0)  # headings come wrapped
    writer = TruthWriter(tmp_path / name, 30.0, eye)
    frames = noisy_frames(3)
    for frame in frames:
        writer.write(frame, (RobotState("R1", state),))
    writer.close()
    writer.close()
    truth = json.loads(
        (tmp_path / ("out/truth.json" if name == "out" else "out.truth.json")).read_text()
    )
    assert truth["fps"] == 30.0
    assert truth["camera"]["size_px"] == [320, 240]
    robot, pixel = truth["frames"][2]["robots"][0], eye.pixel_pose(pose)
    expected = {
        "id": "R1", "x_m": 0.3, "y_m": 0.2, "theta_rad": 0.7,
        "x_px": pixel.x, "y_px": pixel.y, "heading_deg": degrees(pixel.heading),
    }  # fmt: skip
    assert robot == pytest.approx(expected)
    back = list(read_frames(tmp_path / name))
    assert [np.array_equal(a.image, b.image) for a, b in zip(frames, back, strict=True)] == [
        True
    ] * 3
    if name == "out":
        assert (tmp_path / "out" / truth["frames"][1]["file"]).exists()


def test_writer_refuses_what_it_cannot_write(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"unknown video suffix.*\.mkv"):
        VideoWriter(tmp_path / "v.gif", 30.0)
    with pytest.raises(RecordingError, match="cannot be written"):
        VideoWriter(tmp_path / "no" / "v.mkv", 30.0)
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match="cannot be made"):
        TruthWriter(tmp_path / "file" / "out", 30.0, camera())
    writer = VideoWriter(tmp_path / "v.mkv", 30.0)
    writer.write(noisy_frames(1)[0])
    with pytest.raises(RecordingError, match=r"frame 0 has \(10, 12\) px"):
        writer.write(noisy_frames(1, 10, 12)[0])
    writer.close()
    with pytest.raises(RecordingError, match="closed"):
        writer.write(noisy_frames(1)[0])


@real
@pytest.mark.parametrize(("name", "count"), [("still_plates", 50), ("exposure_settling", 220)])
def test_real_video(name: str, count: int) -> None:
    footage = read_frames(REAL / "video" / f"{name}.mpg")
    times = [frame.t_capture for frame in footage]
    assert len(times) == count
    assert np.diff(times) == pytest.approx(np.full(count - 1, 0.04), abs=1e-6)
    assert footage.lost == 0


@real
@pytest.mark.parametrize(("name", "count"), [("agh_b", 13), ("rodetas", 3), ("empty", 3)])
def test_real_images(name: str, count: int) -> None:
    frames = list(read_frames(REAL / name, fps=5.0))
    assert len(frames) == count
    assert frames[-1].t_capture == pytest.approx((count - 1) / 5.0)
    assert all(frame.image.std() > 5 for frame in frames)
