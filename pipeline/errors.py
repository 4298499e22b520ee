"""One error per boundary the pipeline owns; the command line maps each to its exit status."""

from control.errors import EchelonError


class CameraError(EchelonError):
    """A camera cannot be opened or has failed (exit status 3)."""


class RadioError(EchelonError):
    """A radio link cannot be opened or has failed (exit status 3)."""


class ConfigError(EchelonError):
    """A scenario or an option is wrong; the message names file, line and key (exit status 2)."""


class SafetyStop(EchelonError):
    """A safety rule has ended a drive (exit status 4)."""
