"""Hypothesis draws the same examples every time, and no test has a deadline."""

from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")
