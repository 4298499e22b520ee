"""What is wrong with an image file, told before a decoder guesses the missing part."""

import struct
import zlib

_PNG, _JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"
_JPEG_END = b"\xff\xd9"
_AROUND = 12  # bytes of a PNG chunk besides its data: length, kind, checksum


def damage_of(data: bytes) -> str:
    """Look for damage in a PNG or JPEG file.

    Args:
        data: the whole file, whatever its name says.

    Returns:
        What is wrong; empty for an intact PNG, for a JPEG with an end, and for any other format.
    """
    if data.startswith(_JPEG):
        return "" if data.rfind(_JPEG_END) > 0 else "is cut off: no end of the JPEG"
    return _png_damage(data) if data.startswith(_PNG) else ""


def _png_damage(data: bytes) -> str:
    """Go from chunk to chunk and compare the checksums."""
    at = len(_PNG)
    while at + _AROUND <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        end = at + _AROUND + size
        if end > len(data):
            break
        (stated,) = struct.unpack_from(">I", data, end - 4)
        if zlib.crc32(data[at + 4 : end - 4]) != stated:
            return f"is damaged: wrong checksum in the PNG chunk at byte {at}"
        if kind == b"IEND":
            return ""
        at = end
    return f"is cut off: the PNG ends after {len(data)} bytes"
