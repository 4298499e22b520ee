"""What `echelon locate` does: images in, detections and rejections out."""

from math import degrees
from pathlib import Path
from typing import Any

from datasets.errors import RecordingError
from datasets.recorded import image_files, read_image
from pipeline.cli.output import Output
from pipeline.errors import ConfigError
from pipeline.looking import look
from pipeline.readiness import ready_to_look
from pipeline.scenario import load_scenario
from pipeline.seeing import Seeing
from pipeline.viewers.overlay import draw_scene, write_picture
from pipeline.viewers.reasons import with_reasons
from vision.frame import Frame, as_frame
from vision.scene import Detection, Scene


def locate_images(
    images: list[Path],
    scenario: str,
    overrides: tuple[str, ...],
    overlay: Path | None,
    output: Output,
) -> None:
    """Find the robots in images.

    Args:
        images: files; of a folder, all its images.
        scenario: name or file that describes camera, tags and colours.
        overrides: changes to it.
        overlay: folder for pictures with outlines, None for none.
        output: where to say it.

    Raises:
        ConfigError: if the scenario is wrong or does not fit an image's size, or overlays would
            be written over each other or over an image.
        RecordingError: if an image cannot be read or a folder has none.
    """
    seeing = ready_to_look(load_scenario(scenario, overrides))
    images = [file for path in images for file in _files(path)]
    pictures = _pictures(images, overlay)
    found = []
    for sequence, path in enumerate(images):
        frame = as_frame(read_image(path), 0.0, sequence, str(path))
        scene = look(seeing.detector_for(frame.size_px), frame)
        if overlay is not None:
            _draw(seeing, frame, scene, pictures[sequence])
        if output.as_json:
            found.append(_to_json(path, scene, seeing.floor_known))
        else:
            _tell(path, scene, seeing.floor_known, output)
    if output.as_json:
        output.object({"images": found})


def _files(path: Path) -> tuple[Path, ...]:
    """A file, or the images of a folder."""
    if not path.is_dir():
        return (path,)
    found = image_files(path)
    if not found:
        raise RecordingError(f"{path}: a folder without images")
    return found


def _to_json(path: Path, scene: Scene, floor_known: bool) -> dict[str, Any]:
    return {
        "file": str(path),
        "detections": [_detection(d, floor_known) for d in scene.detections],
        "rejected": [{"x_px": r.x, "y_px": r.y, "reason": r.reason} for r in scene.rejected],
    }


def _detection(d: Detection, floor_known: bool) -> dict[str, Any]:
    return {
        "id": d.robot_id,
        "x_px": d.pixel.x,
        "y_px": d.pixel.y,
        "heading_deg": degrees(d.pixel.heading),
        "x_m": d.pose.x if floor_known else None,
        "y_m": d.pose.y if floor_known else None,
        "theta_rad": d.pose.theta if floor_known else None,
        "confidence": d.confidence,
        "residual_px": d.residual_px,
        "ambiguous": d.ambiguous,
    }


def _tell(path: Path, scene: Scene, floor_known: bool, output: Output) -> None:
    """Tables for people."""
    header = ("robot", "x px", "y px", "heading deg", "x m", "y m", "confidence", "residual px")
    rows = [
        (
            f"{d.robot_id}{' ?' * d.ambiguous}", f"{d.pixel.x:.2f}", f"{d.pixel.y:.2f}",
            f"{degrees(d.pixel.heading):.1f}",
            *((f"{d.pose.x:.4f}", f"{d.pose.y:.4f}") if floor_known else ("-", "-")),
            f"{d.confidence:.2f}", f"{d.residual_px:.2f}",
        )
        for d in scene.detections
    ]  # fmt: skip
    output.table(f"{path}: {len(rows)} robots", header, rows)
    if any(d.ambiguous for d in scene.detections):
        output.say("  ?: other robots wear the same tag; a single picture does not tell them apart")
    for r in scene.rejected:
        output.say(f"  not accepted at ({r.x:.0f}, {r.y:.0f}) px: {r.reason}")


def _pictures(images: list[Path], folder: Path | None) -> list[Path]:
    """Where the overlay of each image goes: no two to one place, none over an image."""
    if folder is None:
        return []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"--overlay {folder}: not a folder ({error.strerror})") from None
    paths = [folder / f"{image.stem}.png" for image in images]
    given = {image.resolve() for image in images}
    for path in paths:
        if path.resolve() in given:
            raise ConfigError(f"--overlay {folder}: would overwrite {path}; give another folder")
        if paths.count(path) > 1:
            raise ConfigError(f"--overlay {folder}: several images would be drawn to {path}")
    return paths


def _draw(seeing: Seeing, frame: Frame, scene: Scene, path: Path) -> None:
    camera = seeing.detector_for(frame.size_px).camera
    write_picture(path, with_reasons(draw_scene(frame.image, scene, seeing.tags, camera), scene))
