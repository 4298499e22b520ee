"""A single picture: looked at until nothing more is found, as the live loop would in a moment."""

from vision.detector import Detector
from vision.frame import Frame
from vision.light import BRIGHTNESSES, PALETTE_LIGHT
from vision.locate import Prediction
from vision.scene import Scene

_LOOKS = 6  # at most, with the robots found so far telling the light


def look(detector: Detector, frame: Frame) -> Scene:
    """Find the robots in a picture without a past.

    While nobody is found, other brightnesses are supposed; then the robots found tell the light in
    which the others are looked for.

    Args:
        detector: for frames of this size.
        frame: the picture.

    Returns:
        What was found at last.

    Raises:
        VisionError: if the frame's size is not the camera's.
    """
    first = scene = detector.locate(frame, (), PALETTE_LIGHT)
    for _ in BRIGHTNESSES[1:]:
        if scene.detections or scene.light == PALETTE_LIGHT:
            break
        scene = detector.locate(frame, (), scene.light)
    if not scene.detections:
        return first  # its reasons are those in the palette's own light
    for _ in range(_LOOKS):
        light, count = scene.light, len(scene.detections)
        if count == len(detector.tags.tags):
            break
        known = tuple(Prediction(d.robot_id, d.pose, d.covariance) for d in scene.detections)
        again = detector.locate(frame, known, light)
        if len(again.detections) < count or again.light == light:
            break
        scene = again
    return scene
