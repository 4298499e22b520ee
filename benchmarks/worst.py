"""`python -m benchmarks.worst`: full searches of hostile frames beside that of a clean one."""

from collections.abc import Callable
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.methods import Setting, make_eye_for, shots
from vision.eye import Eye
from vision.frame import Frame, as_frame
from vision.locate import locate

Floats = NDArray[np.float64]
Make = Callable[[np.random.Generator, tuple[int, int], Floats], Floats]

_SIZES = ((320, 240, 3), (640, 480, 12))  # width, height [px], robots
_ROUNDS, _SEEDS = 15, 3
_CELLS = (2, 3, 4, 5, 6, 8)  # of confetti [px]
_BLACK = (12.0, 12.0, 12.0)


def main() -> None:
    """Measure and print."""
    cv2.setNumThreads(1)
    for width, height, robots in _SIZES:
        setting = Setting((width, height), robots, _SEEDS, 0)
        eye = make_eye_for(setting)
        cases = {"clean": [shot.frame for shot in shots(setting, eye.tags)]}
        cases |= hostile((width, height), np.vstack((eye.palette.typical[1:], _BLACK)))
        print(f"\n{width}x{height}, {robots} robots: full search, best of {_ROUNDS}, worst seed")
        clean = 0.0
        for name, frames in cases.items():
            taken = max(_best(frame, eye) for frame in frames)
            clean = clean or taken
            ids = sum(len(locate(frame, eye).detections) for frame in frames)
            print(f"  {name:14} {1e6 * taken:8.0f} us  {taken / clean:5.2f} x  {ids} ids")


def hostile(size_px: tuple[int, int], paints: Floats) -> dict[str, list[Frame]]:
    """Frames that give the search as much to do as can be.

    Args:
        size_px: width and height [px].
        paints: shape (C, 3), BGR of the tags' colours, last that of the floor.

    Returns:
        Frames by the name of their kind.
    """
    makers: dict[str, Make] = {f"confetti {cell} px": _confetti(cell) for cell in _CELLS}
    makers |= {"noise": _noise, "blobs": _blobs, "pairs": _pairs}
    makers |= {"stripes": _stripes, "texture": _texture}
    rngs = [np.random.default_rng(seed) for seed in range(_SEEDS)]
    return {
        name: [
            as_frame(np.clip(make(rng, size_px, paints), 0, 255).astype(np.uint8), 0.0, n)
            for n, rng in enumerate(rngs)
        ]
        for name, make in makers.items()
    }


def _best(frame: Frame, eye: Eye) -> float:
    """Time of one full search [s]."""
    locate(frame, eye)
    times = []
    for _ in range(_ROUNDS):
        start = perf_counter()
        locate(frame, eye)
        times.append(perf_counter() - start)
    return min(times)


def _confetti(cell: int) -> Make:
    """Squares of random colours."""

    def _make(rng: np.random.Generator, size_px: tuple[int, int], paints: Floats) -> Floats:
        width, height = size_px
        tiles = paints[rng.integers(0, len(paints), (-(-height // cell), -(-width // cell)))]
        return np.asarray(np.repeat(np.repeat(tiles, cell, 0), cell, 1)[:height, :width])

    return _make


def _noise(rng: np.random.Generator, size_px: tuple[int, int], _: Floats) -> Floats:
    """Every value as likely."""
    return rng.uniform(0, 256, (size_px[1], size_px[0], 3))


def _blobs(rng: np.random.Generator, size_px: tuple[int, int], paints: Floats) -> Floats:
    """400 patches of about the size of a tag's."""
    return _strewn(rng, size_px, paints, ((-2.0, 0.0),))


def _pairs(rng: np.random.Generator, size_px: tuple[int, int], paints: Floats) -> Floats:
    """400 pairs of patches at about the distance that a tag's have."""
    return _strewn(rng, size_px, paints, ((-2.5, 0.0), (2.5, 0.0)))


def _strewn(
    rng: np.random.Generator, size_px: tuple[int, int], paints: Floats,
    offsets: tuple[tuple[float, float], ...],
) -> Floats:  # fmt: skip
    """Squares in the colours in turn, turned at random, on the floor's colour."""
    image = np.full((size_px[1], size_px[0], 3), 90.0)
    corners = np.array([[-2.0, -4.0], [2.0, -4.0], [2.0, 4.0], [-2.0, 4.0]])
    for number in range(400):
        angle, place = rng.uniform(-np.pi, np.pi), rng.uniform((0, 0), size_px)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        for k, offset in enumerate(offsets):
            color = paints[0 if k == 0 else 1 + number % (len(paints) - 2)]
            points = np.rint(((corners + offset) @ turn.T + place) * 16).astype(np.int32)
            cv2.fillPoly(image, [points], color.tolist(), cv2.LINE_8, 4)
    return image


def _stripes(rng: np.random.Generator, size_px: tuple[int, int], paints: Floats) -> Floats:
    """Bands of 4 px in the colours in turn, askew."""
    x, y = np.meshgrid(np.arange(size_px[0]), np.arange(size_px[1]))
    angle = rng.uniform(0, np.pi)
    band = np.floor((np.cos(angle) * x + np.sin(angle) * y) / 4.0).astype(np.intp)
    return np.asarray(paints[band % (len(paints) - 1)])


def _texture(rng: np.random.Generator, size_px: tuple[int, int], _: Floats) -> Floats:
    """Noise with the spectrum of photographs, 1 / f, in strong colours."""
    width, height = size_px
    fy, fx = np.meshgrid(np.fft.fftfreq(height), np.fft.rfftfreq(width), indexing="ij")
    fall = 1.0 / np.maximum(np.hypot(fx, fy), 1.0 / width)
    planes = [np.fft.irfft2(np.fft.rfft2(rng.normal(size=(height, width))) * fall, (height, width))
              for _ in range(3)]  # fmt: skip
    return np.stack([127.0 + 60.0 * plane / plane.std() for plane in planes], axis=-1)


if __name__ == "__main__":
    main()
