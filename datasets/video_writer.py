"""Writing frames without loss: a video file, or a folder of PNGs; the truth beside them as JSON."""

import json
from fractions import Fraction
from math import degrees
from pathlib import Path
from typing import TypeAlias

import av
import cv2
from av.container import OutputContainer
from av.video.stream import VideoStream

from control.geometry import wrap_angle
from datasets.cycle import RobotState
from datasets.errors import RecordingError
from datasets.session_codec import Plain, form
from vision.camera import CameraModel
from vision.frame import Frame

# Lossless codecs by file name, with the pixel format in which they take BGR unchanged.
_CODECS: dict[str, tuple[str, str, dict[str, str]]] = {
    ".mp4": ("libx264rgb", "bgr24", {"qp": "0", "preset": "ultrafast"}),
    ".mov": ("libx264rgb", "bgr24", {"qp": "0", "preset": "ultrafast"}),
    ".mkv": ("ffv1", "bgr0", {}),
    ".avi": ("ffv1", "bgr0", {}),
}
_TIME_BASE = Fraction(1, 90_000)  # [s]


class VideoWriter:
    """Writes frames to one video file, every pixel unchanged, with their capture times."""

    def __init__(self, path: Path | str, fps: float) -> None:
        """Create the file.

        Args:
            path: its suffix decides the format: .mp4 and .mov (H.264), .mkv and .avi (FFV1).
            fps: nominal frame rate [1/s].

        Raises:
            RecordingError: if the suffix is unknown or the file cannot be created.
        """
        self.path = Path(path)
        if self.path.suffix.lower() not in _CODECS:
            known = ", ".join(_CODECS)
            raise RecordingError(f"{path}: unknown video suffix; use one of {known}, or a folder")
        try:
            self.path.open("wb").close()  # the library would open it, and fail, much later
            self._container: OutputContainer | None = av.open(str(path), mode="w")
        except (av.error.FFmpegError, OSError) as error:
            raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error
        self._fps = Fraction(fps).limit_denominator(1001)
        self._stream: VideoStream | None = None
        self._first = 0.0

    def write(self, frame: Frame) -> None:
        """Append a frame; time starts with the first one.

        Args:
            frame: of the size of the first one, with a later capture time.

        Raises:
            RecordingError: if it has another size or cannot be written.
        """
        if self._container is None:
            raise RecordingError(f"{self.path}: is closed")
        if self._stream is None:
            self._stream = self._start(self._container, frame)
        if frame.size_px != (self._stream.width, self._stream.height):
            raise RecordingError(
                f"{self.path}: frame {frame.sequence} has {frame.size_px} px, the video "
                f"{(self._stream.width, self._stream.height)}"
            )
        picture = av.VideoFrame.from_ndarray(frame.image, format="bgr24")
        picture.pts = round((frame.t_capture - self._first) / _TIME_BASE)
        picture.time_base = _TIME_BASE
        self._mux(picture)

    def close(self) -> None:
        """Finish the file. Safe to call twice.

        Raises:
            RecordingError: if the rest cannot be written.
        """
        if self._container is None:
            return
        if self._stream is not None:
            self._mux(None)
        container, self._container = self._container, None
        container.close()

    def _start(self, container: OutputContainer, frame: Frame) -> VideoStream:
        codec, pixels, options = _CODECS[self.path.suffix.lower()]
        stream = container.add_stream(codec, rate=self._fps, options=options)
        assert isinstance(stream, VideoStream)
        stream.width, stream.height = frame.size_px
        stream.pix_fmt = pixels
        stream.codec_context.time_base = _TIME_BASE
        self._first = frame.t_capture
        return stream

    def _mux(self, picture: av.VideoFrame | None) -> None:
        assert self._container is not None
        assert self._stream is not None
        try:
            self._container.mux(self._stream.encode(picture))
        except (av.error.FFmpegError, OSError) as error:
            raise RecordingError(f"{self.path}: cannot be written ({error})") from error


class FolderWriter:
    """Writes frames as numbered PNGs."""

    def __init__(self, path: Path | str) -> None:
        """Create the folder.

        Args:
            path: the folder; made if missing.

        Raises:
            RecordingError: if it cannot be made.
        """
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RecordingError(f"{path}: cannot be made ({error.strerror})") from error

    def write(self, frame: Frame) -> None:
        """Write one frame.

        Args:
            frame: goes to ``frame_NNNNN.png``.

        Raises:
            RecordingError: if it cannot be written.
        """
        target = self.path / frame_name(frame)
        try:
            target.write_bytes(cv2.imencode(".png", frame.image)[1].tobytes())
        except OSError as error:
            raise RecordingError(f"{target}: cannot be written ({error.strerror})") from error

    def close(self) -> None:
        """Nothing is left to do."""


FrameWriter: TypeAlias = VideoWriter | FolderWriter


def frame_name(frame: Frame) -> str:
    """Name of a frame's image file.

    Args:
        frame: any frame.

    Returns:
        Its file name inside a folder.
    """
    return f"frame_{frame.sequence:05d}.png"


class TruthWriter:
    """Writes frames and the truth beside them: ``truth.json`` in a folder, else NAME.truth.json."""

    def __init__(self, path: Path | str, fps: float, camera: CameraModel) -> None:
        """Create the video, or the folder when the path has no suffix.

        Args:
            path: video file or folder.
            fps: nominal frame rate [1/s].
            camera: that took the frames.

        Raises:
            RecordingError: if it cannot be created.
        """
        path = Path(path)
        folder = path.is_dir() or not path.suffix
        self._frames: FrameWriter = FolderWriter(path) if folder else VideoWriter(path, fps)
        self._truth_path = path / "truth.json" if folder else path.with_suffix(".truth.json")
        self._in_folder = folder
        self._fps = fps
        self._camera = camera
        self._rows: list[Plain] = []

    def write(self, frame: Frame, truth: tuple[RobotState, ...]) -> None:
        """Append one frame.

        Args:
            frame: the picture.
            truth: states of the robots at its capture time [m, m, rad, m/s, rad/s].

        Raises:
            RecordingError: if it cannot be written.
        """
        self._frames.write(frame)
        robots: list[Plain] = [self._robot(robot) for robot in truth]
        file = frame_name(frame) if self._in_folder else self._frames.path.name
        self._rows.append({"t": frame.t_capture, "file": file, "robots": robots})

    def close(self) -> None:
        """Finish the pictures and write the truth. Safe to call twice.

        Raises:
            RecordingError: if they cannot be written.
        """
        self._frames.close()
        camera = form(CameraModel).encode(self._camera)
        truth = {"fps": self._fps, "camera": camera, "frames": self._rows}
        try:
            self._truth_path.write_text(json.dumps(truth, indent=1) + "\n")
        except OSError as error:
            raise RecordingError(f"{self._truth_path}: cannot be written ({error})") from error

    def _robot(self, robot: RobotState) -> Plain:
        pose, pixel = robot.state.pose, self._camera.pixel_pose(robot.state.pose)
        return {
            "id": robot.robot_id,
            "x_m": pose.x,
            "y_m": pose.y,
            "theta_rad": wrap_angle(pose.theta),
            "x_px": pixel.x,
            "y_px": pixel.y,
            "heading_deg": degrees(pixel.heading),
        }
