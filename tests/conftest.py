"""Hypothesis draws the same examples every time, no test has a deadline, and OpenCV is silent."""

import os

from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")
os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")  # as `echelon` has it
