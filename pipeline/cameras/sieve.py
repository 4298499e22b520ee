"""Which pictures of a camera are news: not late, not seen before, of the size it began with."""

from enum import Enum
from math import inf
from typing import Literal

from vision.frame import Frame, is_repeated

Repeats = Literal["pixels", "stamps"]
"""What makes a picture the one before: its pixels bit for bit, or a stamp that does not advance."""


class Verdict(Enum):
    """What becomes of a frame."""

    NEW = "new"
    LATE = "late"
    DUPLICATE = "duplicate"
    WRONG_SIZE = "wrong size"


class Sieve:
    """Judges the frames of one camera in the order of their arrival.

    Attributes:
        size_px: of the first frame, None before; frames of another are no news [px].
    """

    def __init__(self, repeats: Repeats = "pixels") -> None:
        """Start without a past.

        Args:
            repeats: what makes a picture the one before.
        """
        self.size_px: tuple[int, int] | None = None
        self._repeats = repeats
        self._before: Frame | None = None
        self._newest, self._stamp = -inf, -inf

    def vouches(self, stamp: float | None) -> bool:
        """Whether a frame is new whatever its pixels are.

        Args:
            stamp: the camera's own time of it [s], None if it gives none.

        Returns:
            True if stamps decide and this one has advanced.
        """
        return self._repeats == "stamps" and stamp is not None and stamp > self._stamp

    def judge(self, frame: Frame, stamp: float | None = None) -> Verdict:
        """Judge a frame.

        Args:
            frame: the next one; capture times never run backwards for the filters.
            stamp: the camera's own time of it [s], None if it gives none.

        Returns:
            What becomes of it.
        """
        self.size_px = self.size_px or frame.size_px
        if frame.size_px != self.size_px:
            return Verdict.WRONG_SIZE
        if stamp is not None and stamp == self._stamp:
            return Verdict.DUPLICATE
        self._stamp = -inf if stamp is None else stamp
        if self._before is not None and is_repeated(frame, self._before):
            return Verdict.DUPLICATE
        if frame.t_capture <= self._newest:
            return Verdict.LATE
        self._before, self._newest = frame, frame.t_capture
        return Verdict.NEW

    def restart(self) -> None:
        """The camera was opened again: its stamps begin anew, the rest of the past counts on."""
        self._stamp = -inf
