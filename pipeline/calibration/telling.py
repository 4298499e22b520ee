"""How well a camera is known, in words and as JSON."""

from math import acos, degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vision.calibration.floor import floor_spread
from vision.calibration.result import Calibration

Floats = NDArray[np.float64]


def told(calibration: Calibration, tag_height: float) -> tuple[str, ...]:
    """Say what was found and how well it is known.

    Args:
        calibration: with or without a floor.
        tag_height: at which errors on the floor are told [m].

    Returns:
        Sentences.
    """
    return (*_lens(calibration), *_floor(calibration, tag_height))


def to_json(calibration: Calibration, tag_height: float) -> dict[str, Any]:
    """The same for programs.

    Args:
        calibration: with or without a floor.
        tag_height: at which errors on the floor are told [m].

    Returns:
        JSON-able; what is not known is null.
    """
    lens, spread = calibration.lens.tolist(), calibration.deviations.tolist()
    each = zip(calibration.views, calibration.residuals, strict=True)
    return {
        "lens": {
            "size_px": list(calibration.size_px), "focal_px": lens[:2], "center_px": lens[2:4],
            "distortion": lens[4:], "fitted": calibration.terms,
            "std": {"focal_px": spread[:2], "center_px": spread[2:4], "distortion": spread[4:]},
            "reprojection_px": _or_none(calibration.rms_px),
            "reprojection_of_views_left_out_px": _or_none(calibration.cross_px),
        },
        "views": [
            {"name": view.name, "corners": len(view.ids), "rms_px": _rms(residuals)}
            for view, residuals in each
        ],
        "floor": _floor_json(calibration, tag_height),
    }  # fmt: skip


def _lens(calibration: Calibration) -> tuple[str, ...]:
    """Sentences on the lens."""
    if not calibration.covariance.any():
        return ("lens: given",)
    lens, std = calibration.lens, calibration.deviations
    w, h = calibration.size_px
    return (
        f"lens: {w} x {h} px, focal lengths {lens[0]:.2f} +- {std[0]:.2f} and {lens[1]:.2f} +- "
        f"{std[1]:.2f} px, centre ({lens[2]:.2f} +- {std[2]:.2f}, {lens[3]:.2f} +- {std[3]:.2f}) "
        f"px, distortion: {calibration.terms}",
        f"reprojection error: {calibration.rms_px:.3f} px over {len(calibration.views)} views, "
        f"{calibration.cross_px:.3f} px for views left out of the fit",
    )


def _floor(calibration: Calibration, tag_height: float) -> tuple[str, ...]:
    """Sentences on the floor."""
    if calibration.floor is None:
        return ('floor: unknown; give --floor or --points ("locate" gives pixels only)',)
    floor = _floor_json(calibration, tag_height) or {}
    return (
        f"floor: the camera is {floor['camera_height_m']:.3f} m above it, tilted by "
        f"{floor['tilt_deg']:.1f} deg; from {floor['from']}",
        f"floor error: {floor['left_out_rms_mm']:.2f} mm rms, {floor['left_out_max_mm']:.2f} mm at "
        f"most, measured without what is compared; expected over the whole image "
        f"{floor['expected_rms_mm']:.2f} mm rms, {floor['expected_max_mm']:.2f} mm at the worst "
        "border (1 standard deviation)",
    )


def _floor_json(calibration: Calibration, tag_height: float) -> dict[str, Any] | None:
    """Numbers on the floor."""
    floor = calibration.floor
    if floor is None:
        return None
    camera = calibration.camera(tag_height)
    _, spread = floor_spread(
        calibration.size_px, calibration.lens, floor.pose, floor.covariance, tag_height
    )
    spread = spread[np.isfinite(spread)]
    count = floor.views or len(floor.errors)
    return {
        "rotation_rad": floor.pose[:3].tolist(),
        "translation_m": floor.pose[3:].tolist(),
        "from": f"{count} {'views of a board' if floor.views else 'known points'}",
        "camera_height_m": float(camera.position[2]),
        "tilt_deg": degrees(acos(min(1.0, abs(float(camera.rotation[2, 2]))))),
        "reprojection_px": floor.rms_px,
        "left_out_rms_mm": 1e3 * float(np.sqrt(np.mean(floor.errors**2))),
        "left_out_max_mm": 1e3 * float(floor.errors.max()),
        "expected_rms_mm": 1e3 * float(np.sqrt(np.mean(spread**2))),
        "expected_max_mm": 1e3 * float(spread.max()),
    }


def _rms(residuals: Floats) -> float:
    return float(np.sqrt((residuals**2).sum(axis=1).mean()))


def _or_none(value: float) -> float | None:
    return None if np.isnan(value) else value
