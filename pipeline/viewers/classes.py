"""A picture with the colour class of every pixel painted over it."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.palette import NamedColor, Palette

Image = NDArray[np.uint8]

_DIMMED = 0.35  # brightness of what has no class


def draw_classes(image: Image, palette: Palette, colors: tuple[NamedColor, ...]) -> Image:
    """Paint classes in their nominal colours over a dimmed grey copy.

    Args:
        image: shape (H, W, 3), BGR.
        palette: that tells the classes.
        colors: what each class is painted in.

    Returns:
        Shape (H, W, 3).
    """
    paint = {color.name: color.bgr for color in colors}
    table = np.array([(0, 0, 0), *(paint.get(name, (255, 255, 255)) for name in palette.names)])
    grey = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    classes = palette.classify(image)
    shown = np.where(classes[..., None] > 0, table[classes], _DIMMED * grey)
    return np.asarray(shown, np.uint8)
