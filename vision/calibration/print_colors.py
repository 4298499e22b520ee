"""What nominal colours may look like: white balance and stray light, on a grid of guesses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_BALANCES = np.exp(np.linspace(-0.9, 0.9, 9))  # of blue and of red against green
_BALANCE_SPREAD = 0.5  # of their logarithms
_PALES = (0.0, 0.25, 0.5, 0.7)  # shares of stray light: of the mean colour
_TURN = 0.15  # spread of the direction of a colour about its nominal one [rad]
_LIGHT = 0.35  # and of the logarithm of its brightness


@dataclass(frozen=True, slots=True)
class PrintModel:
    """Guesses at how the printed colours look.

    Attributes:
        guesses: shape (G, C, 3), colours of about the nominal brightness, BGR.
        costs: shape (G,), of their white balance.
    """

    guesses: Floats
    costs: Floats

    def compare(self, colors: Floats, seen: NDArray[np.bool_]) -> tuple[float, Floats]:
        """Find the guess that is nearest to some colours.

        Args:
            colors: shape (C, 3), BGR, in any common light.
            seen: shape (C,), which of them are known.

        Returns:
            Cost of the nearest guess; its colours in the same light, shape (C, 3).
        """
        norm, model = np.linalg.norm(colors, axis=1), np.linalg.norm(self.guesses, axis=2)
        turn = np.arccos(np.clip((unit(self.guesses) * unit(colors)).sum(axis=2), -1.0, 1.0))
        light = np.log(np.maximum(norm, 1.0)) - np.log(np.maximum(model, 1.0))
        share = seen / max(int(seen.sum()), 1)
        level = (light * share).sum(axis=1)
        misfit = (turn / _TURN) ** 2 + ((light - level[:, None]) / _LIGHT) ** 2
        total = (misfit * seen).sum(axis=1) + self.costs
        best = int(total.argmin())
        return float(total[best]), self.guesses[best] * np.exp(level[best])


def print_model(nominal: Floats) -> PrintModel:
    """Imagine nominal colours under all lights.

    Args:
        nominal: shape (C, 3), BGR [0..255].

    Returns:
        The guesses.
    """
    blue, red, pale = (g.reshape(-1, 1) for g in np.meshgrid(_BALANCES, _BALANCES, _PALES))
    gains = np.column_stack((blue, np.ones_like(blue), red))
    mean = np.full((1, 3), nominal.mean())
    paled = (1.0 - pale[:, None]) * nominal + pale[:, None] * mean
    strange = (np.log(gains[:, ::2]) ** 2).sum(axis=1) / _BALANCE_SPREAD**2
    return PrintModel(gains[:, None] * paled, strange)


def unit(colors: Floats) -> Floats:
    """Directions of colours.

    Args:
        colors: shape (..., 3).

    Returns:
        The same with length 1; nearly black ones shorter.
    """
    length = np.linalg.norm(colors, axis=-1, keepdims=True)
    direction: Floats = colors / np.maximum(length, 1.0)
    return direction
