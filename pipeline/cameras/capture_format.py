"""Which pictures are asked of a device, and whether it gives them."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CaptureFormat:
    """What is asked of a device; None leaves it to the driver.

    Attributes:
        size_px: width and height [px].
        fps: frames per second.
        pixels: four characters, e.g. MJPG; as `echelon cameras` lists them.
    """

    size_px: tuple[int, int] | None = None
    fps: float | None = None
    pixels: str | None = None


ANY_FORMAT = CaptureFormat()


def format_refused(wanted: CaptureFormat, got: CaptureFormat) -> str | None:
    """Compare what was asked for with what the device does.

    Args:
        wanted: what was asked for.
        got: what the device reports after setting it.

    Returns:
        One sentence with the numbers, None if they agree.
    """
    if wanted.size_px is not None and got.size_px is not None and wanted.size_px != got.size_px:
        asked, done = ("x".join(map(str, size)) for size in (wanted.size_px, got.size_px))
        return f"does not do {asked} px, it offers {done} px"
    if wanted.pixels is not None and got.pixels is not None and wanted.pixels != got.pixels:
        return f"does not send {wanted.pixels}, it offers {got.pixels}"
    if wanted.fps is not None and got.fps and abs(got.fps - wanted.fps) > 0.02 * wanted.fps:
        return f"does not do {wanted.fps:g} frames/s, it offers {got.fps:g}"
    return None


def fourcc(code: str) -> int:
    """Pack the four characters of a pixel format.

    Args:
        code: e.g. MJPG; filled up with blanks.

    Returns:
        The number that drivers know it by.
    """
    return int.from_bytes(code.ljust(4).encode("ascii"), "little")


def pixels_named(number: float) -> str | None:
    """Unpack the four characters of a pixel format.

    Args:
        number: as the device reports it.

    Returns:
        The characters; None if it reports none.
    """
    text = max(0, int(number)).to_bytes(8, "little")[:4].decode("ascii", "replace").strip(" \0")
    return text or None
