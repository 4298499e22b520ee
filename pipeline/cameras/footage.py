"""Recorded footage as a camera on a virtual clock: every frame arrives after the latency."""

from collections.abc import Iterable, Iterator

from pipeline.ports import EndOfStream
from vision.frame import Frame


class FootageCamera:
    """Hands out every frame of a video or folder, in order, none skipped.

    Attributes:
        count: frames handed out.
    """

    def __init__(self, frames: Iterable[Frame], latency: float) -> None:
        """Begin with the first frame.

        Args:
            frames: in the order of their capture times.
            latency: from a frame's capture to its delivery [s].
        """
        self._frames: Iterator[Frame] = iter(frames)
        self._latency = latency
        self._ahead = next(self._frames, None)
        self.count = 0

    def latest(self, now: float) -> Frame | None:
        """The next frame, once its time has come.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The frame, None if it is not due yet.

        Raises:
            EndOfStream: if the last frame was handed out.
        """
        if self._ahead is None:
            raise EndOfStream("the footage is over")
        if self._ahead.t_capture + self._latency > now + 1e-9:
            return None
        due, self._ahead = self._ahead, next(self._frames, None)
        self.count += 1
        return due

    def close(self) -> None:
        """Nothing is held. Safe to call twice."""
