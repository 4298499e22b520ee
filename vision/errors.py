"""The error of the vision boundary."""

from control.errors import EchelonError


class VisionError(EchelonError):
    """A frame, camera, tag layout or palette cannot be used; the message gives the numbers."""
