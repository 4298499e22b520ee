"""Choosing views from a moving picture: sharp ones, held still, different from each other."""

from dataclasses import dataclass, replace

from vision.calibration.detect import BoardView
from vision.calibration.views import DIFFERENT, lacking_regions, motion

STILL = 0.004  # largest mean motion since the frame before, of the image's width
BLURRED = 1.35  # edges this much wider than the sharpest ones seen are blurred


@dataclass(frozen=True, slots=True)
class Selection:
    """The views chosen so far.

    Attributes:
        kept: chosen views.
        before: the board in the frame before, None if it was not seen.
        sharpest: least width of edges seen [px].
    """

    kept: tuple[BoardView, ...] = ()
    before: BoardView | None = None
    sharpest: float = float("inf")

    def complete(self, wanted: int) -> bool:
        """Whether there are enough views all over the image.

        Args:
            wanted: number of views.

        Returns:
            True with the wanted number and no region without corners, or with twice the number.
        """
        if len(self.kept) < wanted:
            return False
        lacking = lacking_regions(self.kept, self.kept[0].size_px)
        return not lacking or len(self.kept) >= 2 * wanted


def offer(selection: Selection, view: BoardView | None) -> tuple[Selection, str]:
    """Consider the next frame.

    Args:
        selection: the views chosen so far.
        view: the board in this frame, None if it is not seen.

    Returns:
        The new selection, and "kept" or why the frame was passed over.
    """
    if view is None:
        return replace(selection, before=None), "no board seen"
    before = selection.before
    seen = replace(selection, before=view, sharpest=min(selection.sharpest, view.blur_px))
    if before is None or motion(before, view) > STILL:
        return seen, "hold still"
    if view.blur_px > BLURRED * seen.sharpest:
        return seen, "blurred"
    if any(motion(view, other) < DIFFERENT for other in seen.kept):
        return seen, "move or tilt the board"
    return replace(seen, kept=(*seen.kept, view)), "kept"
