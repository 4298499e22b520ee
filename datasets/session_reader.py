"""Reading a session: in file order, with bounded memory, also while it grows or after a crash."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.records import Channel, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader

from datasets.cycle import Moment
from datasets.errors import RecordingError
from datasets.session_codec import form
from datasets.session_format import (
    DROPS_TOPIC,
    END_RECORD,
    FORMAT_VERSION,
    HEADER_RECORD,
    IMAGE_TOPIC,
    LAST_TOPIC,
    SessionHeader,
    decode_part,
    join,
)
from datasets.session_image import unpack_image
from vision.errors import VisionError

_RECORD_BYTES = 1 << 28  # a longer record is damage
_HEADER_RECORDS = 8  # the header is among the first few


@dataclass(frozen=True, slots=True)
class SessionEnd:
    """How a session ends.

    Attributes:
        complete: False if the recorder was cut off before it closed the file.
        dropped: moments the recorder had no time for, as far as the file tells.
    """

    complete: bool
    dropped: int


class Session:
    """A recorded session; iterate it, as often as needed, to get its moments in order.

    Attributes:
        path: the file.
        header: what it was recorded with.
    """

    def __init__(self, path: Path, header: SessionHeader) -> None:
        """Use `read_session`.

        Args:
            path: the file.
            header: already read from it.
        """
        self.path = path
        self.header = header
        self._end = SessionEnd(complete=False, dropped=0)

    @property
    def end(self) -> SessionEnd:
        """How the session ends; final once an iteration has come to its end."""
        return self._end

    def __iter__(self) -> Iterator[Moment]:
        """Iterate over the moments.

        Yields:
            Moments equal to those observed; one that was cut off is left out.

        Raises:
            RecordingError: if a record inside the file is damaged.
        """
        assembly = _Assembly(self.path)
        self._end = SessionEnd(complete=False, dropped=0)
        for record in _records(self.path):
            if isinstance(record, Channel):
                assembly.topics[record.id] = record.topic
            elif isinstance(record, Message):
                moment = assembly.add(record)
                if assembly.dropped > self._end.dropped:
                    self._end = SessionEnd(self._end.complete, assembly.dropped)
                if moment is not None:
                    yield moment
            elif isinstance(record, Metadata) and record.name == END_RECORD:
                self._end = SessionEnd(complete=True, dropped=int(record.metadata["dropped"]))


def read_session(path: Path | str) -> Session:
    """Open a recorded session.

    Args:
        path: the file.

    Returns:
        The session with its header; moments are read when it is iterated.

    Raises:
        RecordingError: if the file is missing, empty, no session, or cut off before its header.
    """
    path = Path(path)
    for count, record in enumerate(_records(path)):
        if isinstance(record, Metadata) and record.name == HEADER_RECORD:
            return Session(path, _header(path, record))
        if count > _HEADER_RECORDS:
            break
    raise RecordingError(
        f"{path}: holds no Echelon session (cut off at its start, or written by another program)"
    )


def is_session(path: Path | str) -> bool:
    """Tell whether a file looks like a session, by its first bytes.

    Args:
        path: any path.

    Returns:
        True for a file in the session's container format.
    """
    try:
        with Path(path).open("rb") as stream:
            return stream.read(5) == b"\x89MCAP"
    except OSError:
        return False


def _records(path: Path) -> Iterator[McapRecord]:
    """All whole records of a file, in order; a truncated last one ends it quietly."""
    try:
        with path.open("rb") as stream:
            if not stream.peek(1):
                raise RecordingError(f"{path}: the file is empty")
            yield from StreamReader(stream, record_size_limit=_RECORD_BYTES).records
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error
    except InvalidMagic as error:
        raise RecordingError(f"{path}: is not a session (.mcap) file") from error
    except (EndOfFile, struct.error):
        return  # the process that wrote it was killed, or is still writing
    except (McapError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: a record is damaged ({error})") from error


def _header(path: Path, record: Metadata) -> SessionHeader:
    found = record.metadata.get("format")
    if found != FORMAT_VERSION:
        raise RecordingError(f"{path}: session format {found}, this program reads {FORMAT_VERSION}")
    try:
        header: SessionHeader = form(SessionHeader).decode(json.loads(record.metadata["header"]))
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(f"{path}: its header is damaged ({error!r})") from error
    return header


class _Assembly:
    """Messages of the moment being read, until its last one arrives."""

    def __init__(self, path: Path) -> None:
        self.topics: dict[int, str] = {}
        self.dropped = 0
        self._path = path
        self._sequence = -1
        self._parts: dict[str, Any] = {}

    def add(self, message: Message) -> Moment | None:
        """Take a message; the moment when it was its last one."""
        topic = self.topics[message.channel_id]
        if message.sequence != self._sequence:
            self._sequence, self._parts = message.sequence, {}
        try:
            return self._take(topic, message.data)
        except (ValueError, KeyError, TypeError, VisionError) as error:
            raise RecordingError(
                f"{self._path}: cycle {message.sequence}, channel {topic} is damaged ({error!r})"
            ) from error

    def _take(self, topic: str, data: bytes) -> Moment | None:
        if topic == IMAGE_TOPIC:
            self._parts["image"] = unpack_image(data)
            return None
        self._parts.update(decode_part(topic, json.loads(data)))
        if topic == DROPS_TOPIC:
            self.dropped = self._parts["drops"].dropped
        return join(self._parts, self._parts.get("image")) if topic == LAST_TOPIC else None
