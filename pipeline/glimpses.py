"""A few frames of anything that shows the scene: images, a folder, a video, a session, a camera."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeVar

from datasets.recorded import (
    IMAGE_SUFFIXES,
    Footage,
    image_files,
    is_session,
    read_frames,
    read_image,
    read_session,
)
from pipeline.cameras.open import CameraRequest, open_camera
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError, ConfigError
from pipeline.ports import EndOfStream
from vision.frame import Frame, as_frame

SPACING = 0.3  # between two frames of a camera [s]
POLL = 0.005  # between two looks for a new frame [s]
SILENT = 5.0  # a camera that gives nothing for so long has failed [s]
_T = TypeVar("_T")


def glimpse(sources: tuple[str, ...], count: int) -> tuple[Frame, ...]:
    """Take a few frames.

    Args:
        sources: image files, or one folder, video, session or camera SPEC.
        count: at most so many of a folder, video, session or camera, evenly spread; of image
            files all are taken.

    Returns:
        The frames, all of one size.

    Raises:
        ConfigError: if several sources are not all images, or the sizes differ.
        RecordingError: if a file cannot be read.
        CameraError: if the camera fails.
    """
    if all(Path(s).suffix.lower() in IMAGE_SUFFIXES for s in sources):
        frames = tuple(_image(Path(s), n) for n, s in enumerate(sources))
    elif len(sources) > 1:
        raise ConfigError(f"{', '.join(sources)}: give images, or one folder, video or camera")
    else:
        frames = tuple(_few(sources[0], count))
    sizes = {frame.size_px: frame.camera_id for frame in reversed(frames)}
    if len(sizes) > 1:
        text = ", ".join(f"{name} {w} x {h} px" for (w, h), name in sizes.items())
        raise ConfigError(f"frames of different sizes: {text}")
    return frames


def _image(path: Path, number: int) -> Frame:
    return as_frame(read_image(path), 0.0, number, path.name)


def _few(source: str, count: int) -> Iterable[Frame]:
    path = Path(source)
    if path.is_dir():
        files = _spread(list(image_files(path)), count)
        if files:
            return [_image(file, n) for n, file in enumerate(files)]
        return read_frames(path)  # says what is wrong
    if is_session(path):
        return _evenly(_recorded(path), count)
    if path.is_file():
        return _evenly(_numbered(read_frames(path)), count)
    return _watched(source, count)


def _numbered(footage: Footage) -> Iterator[Frame]:
    yield from footage


def _recorded(path: Path) -> Iterator[Frame]:
    """The frames of a session."""
    for moment in read_session(path):
        if moment.tick.frame is not None:
            yield moment.tick.frame


def _evenly(frames: Iterator[Frame], count: int) -> list[Frame]:
    """Frames spread over a stream of unknown length, holding at most twice as many."""
    kept: list[Frame] = []
    step = 1
    for number, frame in enumerate(frames):
        if number % step == 0:
            kept.append(frame)
        if len(kept) == 2 * count:
            kept, step = kept[::2], 2 * step
    return _spread(kept, count)


def _spread(every: list[_T], count: int) -> list[_T]:
    """At most so many of a list, from its first to its last."""
    if len(every) <= count:
        return every
    return [every[round(n * (len(every) - 1) / max(count - 1, 1))] for n in range(count)]


def _watched(spec: str, count: int) -> list[Frame]:
    """Frames of a camera, some time apart."""
    clock = MonotonicClock()
    camera = open_camera(spec, clock, CameraRequest())
    frames: list[Frame] = []
    due, given_up = clock.now(), clock.now() + SILENT
    try:
        while len(frames) < count:
            frame = camera.latest(clock.now())
            if frame is not None and clock.now() >= due:
                frames.append(frame)
                due, given_up = clock.now() + SPACING, clock.now() + SILENT
            if clock.now() > given_up:
                raise CameraError(f"camera {spec}: no frame for {SILENT:.0f} s")
            clock.wait_until(clock.now() + POLL)
    except EndOfStream:
        pass  # fewer than wanted will do
    finally:
        camera.close()
    if not frames:
        raise CameraError(f"camera {spec}: gave no frame")
    return frames
