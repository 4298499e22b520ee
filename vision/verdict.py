"""What speaks for and against fitted candidates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Verdict:
    """Scores of fitted candidates.

    Attributes:
        scores: shape (N, T), probability that candidate n has the colours of tag t rather than any
            colours, 0 where it is not possible.
        sound: shape (N,), whether place and misfit are those of a tag, whatever the colours.
        good: shape (N,), whether the candidate can be accepted.
        moved: shape (N,), way of the fit from where it began [m].
        overhang: shape (N,), how far the plate reaches beyond the image [px].
        screen: shape (N, 3), where they are in the image [px, px, rad].
        hidden: shape (N,), share that is covered of tags that are refused for it, else 0.
        twice: shape (N,), index of the tag of a robot already found that they look like, else -1.
        unlike: shape (N, 3), what speaks against a tag: misfit, colours and plate; see `evidence`.
    """

    scores: Floats
    sound: NDArray[np.bool_]
    good: NDArray[np.bool_]
    moved: Floats
    overhang: Floats
    screen: Floats
    hidden: Floats
    twice: Indices
    unlike: Floats

    def keep(self, missing: NDArray[np.bool_], confidence: float) -> None:
        """Consider some tags only; of candidates that have the colours of another, say so.

        Args:
            missing: shape (T,), which tags to consider.
            confidence: least score.
        """
        best, before = self.scores.argmax(axis=1), self.good.copy()
        self.scores[:, ~missing] = 0.0
        self.good[self.scores.max(axis=1) < confidence] = False
        twice = before & ~self.good
        self.twice[twice] = best[twice]

    def refuse_covered(self, chosen: Indices, hidden: Floats) -> None:
        """Refuse candidates of which too much is covered.

        Args:
            chosen: shape (R,), their indices.
            hidden: shape (R,), share of each that is covered.
        """
        self.hidden[chosen] = hidden
        self.good[chosen] = self.sound[chosen] = False
