"""The cases in which the fit is held against its bound: size, noise, blur and codec."""

from dataclasses import dataclass, replace
from itertools import product

from benchmarks.field import MOUNT, SIDE, TAG_HEIGHT, Field, make_camera, make_field, two_patch
from datasets.floor import Floor
from datasets.sensor import Chroma, SensorModel

PLATES_PX = (8, 10, 12, 16, 24, 32)
NOISES = (1.0, 3.0, 6.0)
BLURS_PX = (0.4, 0.6, 1.0)
CODECS = ("444", "420", "420 jpeg 85")
ROBOTS, SIZE_PX = 7, (400, 300)
PLAIN = Floor(texture=0.0, line_width=0.0)


@dataclass(frozen=True, slots=True)
class Case:
    """What the camera is like.

    Attributes:
        plate_px: side of a robot's plate in the picture [px].
        noise: of the sensor, of 255.
        blur_px: of the lens [px].
        codec: one of `CODECS`.
        floor: under the robots.
    """

    plate_px: float
    noise: float
    blur_px: float
    codec: str
    floor: Floor = PLAIN

    @property
    def sensor(self) -> SensorModel:
        """The camera's sensor, under even light."""
        quality = 85 if "jpeg" in self.codec else None
        plain = SensorModel(self.noise, self.blur_px, jpeg_quality=quality, chroma="444")
        return replace(plain, chroma=self.kept)

    @property
    def kept(self) -> Chroma:
        """What the codec keeps of the colours."""
        return "444" if self.codec == "444" else "420"


def cases(quick: bool) -> list[Case]:
    """What is measured.

    Args:
        quick: only some sizes and blurs at noise 3.

    Returns:
        The cases, those that share poses one after the other.
    """
    if quick:
        return [Case(p, 3.0, b, c) for p, b, c in product((8, 10, 16, 32), (0.6, 1.0), CODECS)]
    every = product(PLATES_PX, BLURS_PX, NOISES, CODECS)
    return [Case(p, n, b, c) for p, b, n, c in every]


def make_case_field(case: Case) -> Field:
    """A field as a case wants it.

    Args:
        case: what the camera is like.

    Returns:
        The field, with 7 robots.
    """
    width = SIZE_PX[0] * SIDE / case.plate_px * MOUNT / (MOUNT - TAG_HEIGHT)
    return make_field(make_camera(SIZE_PX, width), two_patch(ROBOTS), case.sensor, case.floor)
