"""The base of every error Echelon raises on purpose."""


class EchelonError(Exception):
    """An error with a message fit to be shown to a user as one line."""


class ControlError(EchelonError):
    """A control input is not usable: non-finite, out of range, or an inconsistent formation."""
