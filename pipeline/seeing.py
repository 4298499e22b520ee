"""What a scenario says of seeing: camera, tags, colours, sharpness, and who finds the robots."""

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.camera_model import make_camera
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.layouts import make_markers, make_tags, nominal_colors
from vision.aruco import ArucoDetector
from vision.calibration.learned import Print, palette_from_samples
from vision.camera import CameraModel
from vision.detector import ColorDetector, Detector
from vision.errors import VisionError
from vision.eye import Eye, make_eye
from vision.optics import ChromaModel, Optics
from vision.palette import ColorSamples, NamedColor, Palette, palette_from_colors
from vision.tags import TagSet


@dataclass(frozen=True)
class Seeing:
    """All that is needed to find robots in frames.

    Attributes:
        name: of the scenario.
        camera: the calibrated camera.
        floor_known: whether poses in metres mean anything.
        tags: what the robots wear.
        any_size: whether frames of another size are looked at through the same field of view.
        detector: for frames of the camera's own size.
        build: makes a detector for the camera at another size.
    """

    name: str
    camera: CameraModel
    floor_known: bool
    tags: TagSet
    any_size: bool
    detector: Detector
    build: Callable[[CameraModel], Detector]
    _detectors: dict[tuple[int, int], Detector] = field(default_factory=dict, repr=False)

    def detector_for(self, size_px: tuple[int, int]) -> Detector:
        """The detector for frames of a size.

        Args:
            size_px: width and height of the frames [px].

        Returns:
            The scenario's detector, or one scaled to the size where the scenario allows it.

        Raises:
            ConfigError: if the size is another and the scenario does not allow it.
        """
        if size_px == self.camera.size_px:
            return self.detector
        if not self.any_size:
            raise ConfigError(
                f"a frame is {size_px[0]} x {size_px[1]} px, the camera of {self.name} "
                f"{self.camera.size_px[0]} x {self.camera.size_px[1]} px; if both show the same "
                f'field, say camera.other_sizes = "scale"'
            )
        if size_px not in self._detectors:
            self._detectors[size_px] = self.build(self.camera.scaled_to(size_px))
        return self._detectors[size_px]


def make_seeing(scenario: Scenario) -> Seeing:
    """Build what finds the robots: camera, sensor, tags, colours and robots are all it needs.

    Args:
        scenario: checked scenario.

    Returns:
        The seeing; its first looks compile or load what they need.

    Raises:
        ConfigError: if the camera or the tags are inconsistent.
    """
    cv2.setNumThreads(1)  # on small windows threads cost more than they give, and jitter
    try:
        tags = make_tags(scenario)
        camera = make_camera(scenario.camera, tags.tags[0].side)
        build = _builder(scenario, camera, tags)
        any_size = scenario.camera.other_sizes == "scale"
        floor_known = scenario.camera.floor_known
        detector = build(camera)
        return Seeing(scenario.name, camera, floor_known, tags, any_size, detector, build)
    except VisionError as error:
        raise ConfigError(f"scenario {scenario.name}: {error}") from None


def _builder(
    scenario: Scenario, camera: CameraModel, tags: TagSet
) -> Callable[[CameraModel], Detector]:
    """What makes a detector for a camera: printed markers or coloured tags."""
    markers = make_markers(scenario)
    if markers is not None:
        return lambda scaled: ArucoDetector(scaled, markers)
    eye = scenario_eye(scenario, camera, tags)

    def _colored(scaled: CameraModel) -> Detector:
        if scaled is camera:
            return ColorDetector(eye)
        field_px = _scaled(eye.field_px, camera.size_px, scaled.size_px)
        return ColorDetector(
            make_eye(scaled, tags, eye.palette, eye.optics, eye.thresholds, field_px)
        )

    return _colored


def _scaled(
    corners: NDArray[np.float64] | None, before: tuple[int, int], after: tuple[int, int]
) -> NDArray[np.float64] | None:
    """Places in an image at another size."""
    factor = np.array(after) / np.array(before)
    return None if corners is None else (corners + 0.5) * factor - 0.5


def colored_eye(seeing: Seeing, size_px: tuple[int, int]) -> Eye:
    """The eye behind a detector of colours.

    Args:
        seeing: of a scenario.
        size_px: width and height of the frames [px].

    Returns:
        The eye.

    Raises:
        ConfigError: if the robots wear printed markers, or frames of the size are not allowed.
    """
    detector = seeing.detector_for(size_px)
    if not isinstance(detector, ColorDetector):
        raise ConfigError(f"scenario {seeing.name}: its robots wear markers, not colours")
    return detector.eye


def named_colors(scenario: Scenario) -> tuple[NamedColor, ...]:
    """The scenario's colours as the camera sees them under full light.

    Args:
        scenario: with colours as "#rrggbb".

    Returns:
        The colours, those of the layout among them.

    Raises:
        ConfigError: if the layout is unknown.
    """
    return tuple(
        NamedColor(name, (int(c[5:7], 16), int(c[3:5], 16), int(c[1:3], 16)))
        for name, c in nominal_colors(scenario).items()
    )


def scenario_eye(scenario: Scenario, camera: CameraModel, tags: TagSet) -> Eye:
    """What `locate` needs: a palette of the tags' colours, the camera's sharpness and noise.

    Args:
        scenario: sensor and colours.
        camera: that takes the frames.
        tags: worn by the robots.

    Returns:
        The eye.

    Raises:
        ConfigError: if [palette] lacks a colour of the tags.
    """
    s = scenario.sensor
    chroma = ChromaModel(s.chroma, s.chroma_offset_px, s.chroma_upsampling)
    palette = scenario_palette(scenario, tags)
    field_px = scenario.camera.field_px
    corners = None if field_px is None else np.array(field_px)
    optics = Optics(s.blur_px, s.read_noise, chroma)
    return make_eye(camera, tags, palette, optics, field_px=corners)


def scenario_palette(scenario: Scenario, tags: TagSet) -> Palette:
    """The palette of the tags' colours: as measured, or else from the nominal colours.

    Args:
        scenario: its [palette] or its [colors].
        tags: worn by the robots.

    Returns:
        The palette.

    Raises:
        ConfigError: if [palette] lacks a colour of the tags, or was learned of other colours.
    """
    config = scenario.palette
    if config is None:
        used = tuple(c for c in named_colors(scenario) if c.name in tags.colors)
        return palette_from_colors(used, noise=max(scenario.sensor.read_noise, 1.0))
    known = {"black", "floor", *nominal_colors(scenario)}
    strange = sorted(set(config.samples) - known)
    if strange:
        raise ConfigError(
            f"scenario {scenario.name}: palette.samples has {', '.join(strange)}, which "
            f"{'is' if len(strange) == 1 else 'are'} not among the scenario's colours: "
            f"{', '.join(sorted(known - {'floor'}))}; its file was made for other tags"
        )
    lacking = [name for name in tags.search_colors if name not in config.samples]
    if lacking:
        raise ConfigError(
            f"scenario {scenario.name}: palette.samples lacks {', '.join(lacking)}, which the tags "
            "need; run echelon calibrate colors with all robots in the picture"
        )
    used_names = {*tags.search_colors, "black", "floor"}
    samples = tuple(
        ColorSamples(name, np.array(pixels, np.uint8))
        for name, pixels in config.samples.items()
        if name in used_names
    )
    prints = tuple(Print(name, config.prints[name]) for name in tags.search_colors)
    return palette_from_samples(samples, prints, config.light)
