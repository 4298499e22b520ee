"""The recorder: an observer that writes every moment to an .mcap file from a thread of its own."""

from collections import deque
from pathlib import Path
from threading import Condition, Thread

from mcap.writer import CompressionType, Writer

from datasets.cycle import Moment
from datasets.errors import RecordingError
from datasets.session_codec import dumps, form
from datasets.session_format import (
    DROPS_TOPIC,
    END_RECORD,
    FORMAT_VERSION,
    HEADER_RECORD,
    IMAGE_TOPIC,
    Drops,
    SessionHeader,
    channel_schemas,
    encode_part,
    split,
)
from datasets.session_image import SCHEMA_NAME, image_schema, pack_image

# A chunk is closed, and handed to the system, as soon as it holds this much: every picture and
# every few ticks. What a killed process loses is less than one chunk.
_CHUNK_BYTES = 8192
_LOSSLESS_MOMENTS = 64  # short, so that little is still in memory when the process is killed
_REAL_TIME_MOMENTS = 8192  # 40 s of 5 ms cycles
_REAL_TIME_BYTES = 1 << 30  # 15 s of 1280x720 at 30 fps


class _Backlog:
    """Moments on their way to the file, bounded in number and in bytes of pictures."""

    def __init__(self, moments: int, picture_bytes: int) -> None:
        self._limits = moments, picture_bytes
        self._queue: deque[Moment | None] = deque()
        self._bytes = 0
        self._changed = Condition()

    def put(self, moment: Moment | None, wait: bool) -> bool:
        """Add a moment, or None for the end; False if there is no room and no wait."""
        size = _picture_bytes(moment)
        with self._changed:
            while moment is not None and self._queue and not self._has_room(size):
                if not wait:
                    return False
                self._changed.wait()
            self._queue.append(moment)
            self._bytes += size
            self._changed.notify_all()
        return True

    def get(self) -> Moment | None:
        """Wait for the next moment; None is the end."""
        with self._changed:
            while not self._queue:
                self._changed.wait()
            moment = self._queue.popleft()
            self._bytes -= _picture_bytes(moment)
            self._changed.notify_all()
        return moment

    def _has_room(self, size: int) -> bool:
        return len(self._queue) < self._limits[0] and self._bytes + size <= self._limits[1]


def _picture_bytes(moment: Moment | None) -> int:
    return moment.tick.frame.image.nbytes if moment is not None and moment.tick.frame else 0


class SessionWriter:
    """Records a session; safe against being killed at any time.

    Attributes:
        path: the file.
    """

    def __init__(self, path: Path | str, header: SessionHeader, lossless: bool = False) -> None:
        """Create the file and start writing.

        Args:
            path: file to write, by convention ``*.mcap``; an older one is replaced.
            header: what the session is recorded with.
            lossless: when behind, make the loop wait (a run without a real-time clock); else
                moments are dropped, counted, and the count is written.

        Raises:
            RecordingError: if the file cannot be created.
        """
        self.path = Path(path)
        self._lossless = lossless
        try:
            self._file = _SessionFile(self.path, header)
        except OSError as error:
            raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error
        few = (_LOSSLESS_MOMENTS, _REAL_TIME_BYTES)
        self._backlog = _Backlog(*few if lossless else (_REAL_TIME_MOMENTS, _REAL_TIME_BYTES))
        self._dropped = 0
        self._failure: Exception | None = None
        self._thread: Thread | None = Thread(target=self._write, name="recorder", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Moments lost since the start because writing was too slow or had failed."""
        return self._dropped

    def observe(self, moment: Moment) -> None:
        """Queue one cycle for the file.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        running = self._failure is None and self._thread is not None
        if not (running and self._backlog.put(moment, self._lossless)):
            self._dropped += 1

    def close(self) -> None:
        """Write what is queued and finish the file. Safe to call twice.

        Raises:
            RecordingError: if anything could not be written; the message says what is lost.
        """
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._backlog.put(None, wait=True)
        thread.join()
        try:
            self._file.finish(self._dropped)
        except OSError as error:
            self._failure = self._failure or error
        if self._failure is not None:
            raise RecordingError(
                f"{self.path}: recording failed ({self._failure}); "
                f"{self._dropped} cycles are not in it"
            ) from self._failure

    def _write(self) -> None:
        """Runs on the recorder's thread until the end of the queue."""
        while (moment := self._backlog.get()) is not None:
            if self._failure is not None:
                self._dropped += 1
                continue
            try:
                self._file.write(moment, self._dropped)
            except Exception as error:  # noqa: BLE001 (a thread's error must reach its owner)
                self._failure = error
                self._dropped += 1


class _SessionFile:
    """The open file: channels, and moments as messages."""

    def __init__(self, path: Path, header: SessionHeader) -> None:
        self._stream = path.open("wb")
        self._mcap = Writer(self._stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.NONE)
        self._mcap.start(profile="", library=f"echelon session {FORMAT_VERSION}")
        text = dumps(form(SessionHeader).encode(header)).decode()
        self._mcap.add_metadata(HEADER_RECORD, {"format": FORMAT_VERSION, "header": text})
        self._channels = _register(self._mcap)
        self._count = 0
        self._told = 0
        self._stream.flush()

    def write(self, moment: Moment, dropped: int) -> None:
        """Write one moment; hand the file to the system with every picture."""
        t, frame = moment.tick.t, moment.tick.frame
        if dropped > self._told:
            self._told = dropped
            drops = encode_part(DROPS_TOPIC, t, {"drops": Drops(t, dropped)})
            self._add(DROPS_TOPIC, t, dumps(drops))
        if frame is not None:
            self._add(IMAGE_TOPIC, frame.t_capture, pack_image(frame))
        for topic, plain in split(moment):
            self._add(topic, t, dumps(plain))
        self._count += 1
        self._stream.flush()

    def finish(self, dropped: int) -> None:
        """Write the end and close."""
        try:
            end = {"dropped": str(dropped), "moments": str(self._count)}
            self._mcap.add_metadata(END_RECORD, end)
            self._mcap.finish()  # type: ignore[no-untyped-call] # the library gives no types
        finally:
            self._stream.close()

    def _add(self, topic: str, t: float, data: bytes) -> None:
        nanos = max(round(t * 1e9), 0)  # the format knows no negative times; the data does
        self._mcap.add_message(
            self._channels[topic], nanos, data, publish_time=nanos, sequence=self._count
        )


def _register(mcap: Writer) -> dict[str, int]:
    """Announce all channels; ids by topic."""
    image = mcap.register_schema(SCHEMA_NAME, "protobuf", image_schema())
    channels = {IMAGE_TOPIC: mcap.register_channel(IMAGE_TOPIC, "protobuf", image)}
    for topic, schema in channel_schemas().items():
        schema_id = mcap.register_schema(f"echelon{topic}", "jsonschema", dumps(schema))
        channels[topic] = mcap.register_channel(topic, "json", schema_id)
    return channels
