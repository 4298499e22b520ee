"""How frames arrive: some never, some twice, some with a wrong time on them. Seeded."""

from dataclasses import dataclass

import numpy as np

_LOST, _AGAIN, _STAMP = 6, 7, 8  # streams of randomness
_MOST = 3.0  # standard deviations of a stamp's error at most


@dataclass(frozen=True, slots=True)
class Delivery:
    """What happens to frames on their way; a frame's lot depends on the seed and its number alone.

    Attributes:
        jitter: standard deviation of the error of the time on a frame [s].
        dropped: share of the frames that never arrive.
        repeated: share of the frames that show the picture before, with a stamp of their own, as
            drivers and decoders do that have nothing new at hand.
        latency: after its capture a frame arrives; no stamp is later than that [s].
        seed: of all that, >= 0.
    """

    jitter: float = 0.0
    dropped: float = 0.0
    repeated: float = 0.0
    latency: float = 0.0
    seed: int = 0

    def arrives(self, number: int) -> bool:
        """Tell whether a frame arrives at all.

        Args:
            number: of the frame, >= 0.

        Returns:
            False if it is lost.
        """
        return not self._happens(self.dropped, number, _LOST)

    def shown(self, number: int) -> int:
        """Tell which picture a frame shows.

        Args:
            number: of the frame, >= 0.

        Returns:
            Number of the picture: the frame's own, or an earlier one.
        """
        while number > 0 and self._happens(self.repeated, number, _AGAIN):
            number -= 1
        return number

    def stamp(self, number: int, t: float, period: float) -> float:
        """Put a time on a frame.

        Args:
            number: of the frame, >= 0.
            t: when it was taken [s].
            period: between two frames; stamps never change their order [s].

        Returns:
            What the frame says about its capture [s].
        """
        if not self.jitter:
            return t
        error = self.jitter * np.random.default_rng((self.seed, number, _STAMP)).standard_normal()
        most = min(_MOST * self.jitter, 0.45 * period)
        return t + float(np.clip(error, -most, min(most, self.latency)))

    def _happens(self, share: float, number: int, stream: int) -> bool:
        """Whether one of `share` of all frames meets this one."""
        return bool(share) and np.random.default_rng((self.seed, number, stream)).random() < share
