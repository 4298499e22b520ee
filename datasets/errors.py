"""The error of the file boundary."""

from control.errors import EchelonError


class RecordingError(EchelonError):
    """A session, video or image folder cannot be read or written; the message names the file."""


class SimulationError(EchelonError):
    """A simulated world, renderer or sensor cannot be used as asked; the message gives numbers."""
