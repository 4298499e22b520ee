"""Being a user without rights for a while: root may open everything."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

NOBODY = 65534  # a user id without rights


@contextmanager
def as_nobody() -> Iterator[None]:
    """Give up all rights, and take them again."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(user)
