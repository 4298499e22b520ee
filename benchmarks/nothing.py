"""`python -m benchmarks.nothing 2000`: frames without robots, in which nobody may be found."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.layouts import make_tags, shipped_layout
from pipeline.scenario import check_tables
from pipeline.seeing import scenario_palette
from vision.camera import overhead_camera
from vision.eye import ChromaModel, Eye, Optics, make_eye
from vision.frame import Frame, as_frame
from vision.locate import locate

Bytes = NDArray[np.uint8]

LAYOUTS = ("two_patch", "triangle", "quarters", "vsss", "vsss_corner", "ssl_butterfly")
SIDES_PX = (10.0, 16.0)
_SIZE_PX = (320, 240)
_BLURS_PX = (0.7, 1.2, 2.0, 3.0, 4.5, 7.0)
_SPREADS = (6.0, 20.0, 60.0)  # of Gaussian noise [grey levels]
_CONTRASTS = (40.0, 90.0, 200.0)  # of clouds: standard deviation before they are cut off


@dataclass(frozen=True, slots=True)
class Nothing:
    """A frame without robots.

    Attributes:
        kind: what it shows.
        frame: the picture.
    """

    kind: str
    frame: Frame


def main() -> None:
    """Look at so many frames with every layout."""
    count, total = int(sys.argv[1]), 0
    for layout in LAYOUTS:
        for side_px in SIDES_PX:
            eye, found = nobodys_eye(layout, side_px), dict[str, int]()
            for nothing in nothings(count):
                seen = len(locate(nothing.frame, eye).detections)
                found[nothing.kind] = found.get(nothing.kind, 0) + seen
            total += sum(found.values())
            some = {kind: number for kind, number in found.items() if number}
            print(f"{layout:14} {side_px:4.0f} px: {sum(found.values())} ids", some, flush=True)
    print(f"{total} ids in {count * len(LAYOUTS) * len(SIDES_PX)} looks")


def nobodys_eye(layout: str, side_px: float) -> Eye:
    """An eye for all tags of a layout.

    Args:
        layout: its name.
        side_px: side of a tag in the picture [px].

    Returns:
        The eye.
    """
    patterns = list(shipped_layout(layout).patterns)
    robots = [{"id": n, "pattern": pattern} for n, pattern in enumerate(patterns)]
    tables = {"name": "nothing", "tags": {"layout": layout}, "robots": robots}
    scenario = check_tables(tables, "nothing")
    tags = make_tags(scenario)
    width = _SIZE_PX[0] * tags.tags[0].side / side_px
    camera = overhead_camera(_SIZE_PX, width, (0.0, 0.0), width, 0.075)
    optics = Optics(0.6, 3.0, ChromaModel("420", (0.0, 0.0)))
    return make_eye(camera, tags, scenario_palette(scenario, tags), optics)


def nothings(count: int, first: int = 0) -> Iterator[Nothing]:
    """Draw noise, by turns of every kind.

    Args:
        count: number of frames.
        first: number of the first one; every number stands for one picture.

    Yields:
        The frames.
    """
    for number in range(first, first + count):
        rng = np.random.default_rng((number, 7))
        kind, image = _KINDS[number % len(_KINDS)](rng)
        yield Nothing(kind, as_frame(np.clip(image, 0, 255).astype(np.uint8), 0.0, number))


def _white(rng: np.random.Generator) -> tuple[str, NDArray[np.float64]]:
    """Every colour as likely."""
    return "white", rng.uniform(0, 256, (*_SIZE_PX[::-1], 3))


def _grey(rng: np.random.Generator) -> tuple[str, NDArray[np.float64]]:
    """Every brightness as likely."""
    return "grey", np.repeat(rng.uniform(0, 256, (*_SIZE_PX[::-1], 1)), 3, axis=2)


def _gaussian(rng: np.random.Generator) -> tuple[str, NDArray[np.float64]]:
    """One colour, and noise."""
    spread = float(rng.choice(_SPREADS))
    return "gaussian", rng.normal(rng.uniform(0, 255, 3), spread, (*_SIZE_PX[::-1], 3))


def _clouds(rng: np.random.Generator) -> tuple[str, NDArray[np.float64]]:
    """Blurred noise, from pale to saturated."""
    blur, contrast = float(rng.choice(_BLURS_PX)), float(rng.choice(_CONTRASTS))
    noise = rng.normal(0.0, 1.0, (*_SIZE_PX[::-1], 3))
    clouds = cv2.GaussianBlur(noise, (0, 0), blur)
    image = rng.uniform(60, 190, 3) + contrast * clouds / clouds.std()
    return f"clouds {blur:g} px", image + rng.normal(
        0.0, float(rng.choice((0.0, 3.0))), clouds.shape
    )


_KINDS = (_clouds, _white, _clouds, _grey, _clouds, _gaussian)

if __name__ == "__main__":
    main()
