"""What `echelon cameras` does: ask every device, and tell."""

import sys
from collections.abc import Iterator
from dataclasses import asdict

from pipeline.cameras.capabilities import CameraDescription, Control, FrameSize
from pipeline.cameras.found import NO_CAMERA, NOT_LINUX, find_cameras
from pipeline.cli.output import Output


def list_cameras(output: Output) -> None:
    """Tell which cameras there are.

    Args:
        output: where to say it.
    """
    found = find_cameras()
    advice = "" if found else NO_CAMERA if sys.platform == "linux" else NOT_LINUX
    if output.as_json:
        output.object({"cameras": [asdict(camera) for camera in found], "advice": advice or None})
        return
    if advice:
        output.say(advice)
    for camera in found:
        tell_camera(camera, output)


def tell_camera(camera: CameraDescription, output: Output) -> None:
    """Tell of one camera.

    Args:
        camera: as it described itself.
        output: where to say it.
    """
    if camera.problem:
        output.say(f"{camera.path}: {camera.problem}")
        return
    output.say(f"{camera.path}: {camera.card} ({camera.driver}, {camera.bus})")
    output.say(f"  echelon live --camera {camera.spec}")
    formats = [
        (one.code, _size(size), _rates(size)) for one in camera.formats for size in one.sizes
    ]
    output.table("Formats", ("pixels", "size px", "frames/s"), formats)
    output.table(
        "Controls", ("control", "now", "range", "default", "held by"), _rows(camera.controls)
    )


def _size(size: FrameSize) -> str:
    low, high = ("x".join(map(str, ends)) for ends in (size.low_px, size.high_px))
    return low if low == high else f"{low} to {high}, steps of {'x'.join(map(str, size.step_px))}"


def _rates(size: FrameSize) -> str:
    if size.any_fps and size.fps:
        return f"{size.fps[-1]:g} to {size.fps[0]:g}"
    return ", ".join(f"{rate:g}" for rate in size.fps) or "not said"


def _rows(controls: tuple[Control, ...]) -> Iterator[tuple[str, ...]]:
    for control in controls:
        names = dict(control.choices)
        offered = ", ".join(names.values()) or f"{control.minimum} to {control.maximum}"
        now, default = (
            "?" if value is None else names.get(value, str(value))
            for value in (control.value, control.default)
        )
        yield control.name, now, offered, default, _holder(control)


def _holder(control: Control) -> str:
    return "the camera (automatic)" if control.locked_out else "whoever sets it"
