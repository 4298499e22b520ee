"""Everything recorded, through one door: sessions, videos, image folders.

The files beside this one (``session_*.py``, ``video*.py``) are the only place that knows formats.
"""

from datasets.session_format import SessionHeader, software_versions
from datasets.session_reader import Session, SessionEnd, is_session, read_session
from datasets.session_writer import SessionWriter
from datasets.video import IMAGE_SUFFIXES, Footage, image_files, read_frames, read_image
from datasets.video_writer import FolderWriter, TruthWriter, VideoWriter

__all__ = [
    "IMAGE_SUFFIXES",
    "FolderWriter",
    "Footage",
    "Session",
    "SessionEnd",
    "SessionHeader",
    "SessionWriter",
    "TruthWriter",
    "VideoWriter",
    "image_files",
    "is_session",
    "read_frames",
    "read_image",
    "read_session",
    "software_versions",
]
