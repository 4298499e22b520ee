"""The renderer as a camera: pictures of a simulated world, taken at exact instants."""

from math import floor

from datasets.render import Renderer
from datasets.world import World
from pipeline.cameras.delivery import Delivery
from pipeline.cameras.report import CameraReport
from pipeline.cameras.tally import Tally
from pipeline.ports import EndOfStream
from vision.frame import Frame, as_frame

_FAITHFUL = Delivery()
_SLACK = 1e-9  # a frame is not missed for the rounding of its time [s]


class RenderedCamera:
    """Takes picture n at n / fps and delivers it after the latency; only delivered ones are drawn.

    Pictures lost on their way are not counted, as nobody knows of them.
    """

    def __init__(
        self,
        world: World,
        renderer: Renderer,
        fps: float,
        latency: float,
        duration: float | None = None,
        delivery: Delivery = _FAITHFUL,
    ) -> None:
        """Look at a world.

        Args:
            world: it is advanced to the present at every call.
            renderer: draws it.
            fps: pictures per second.
            latency: from the picture to its delivery, less than the world remembers (1 s) [s].
            duration: no picture is taken from this time on [s]; None: without end.
            delivery: what happens to frames on their way.
        """
        self._world, self._renderer = world, renderer
        self._fps, self._latency, self._duration = fps, latency, duration
        self._delivery = delivery
        self._next, self._tally = 0, Tally()

    @property
    def report(self) -> CameraReport:
        """What was delivered so far."""
        return self._tally.report

    def latest(self, now: float) -> Frame | None:
        """Draw the newest picture that has arrived.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The picture, None if there is no new one.

        Raises:
            EndOfStream: if the last picture was handed out.
        """
        self._world.advance(now)
        number = self._newest(now - self._latency)
        if number < self._next:
            if self._duration is not None and self._next / self._fps >= self._duration - _SLACK:
                raise EndOfStream("rendered camera: the duration is over")
            return None
        arrived = [n for n in range(self._next, number + 1) if self._delivery.arrives(n)]
        self._next = number + 1
        if not arrived:
            return None
        for t in (n / self._fps for n in arrived):
            self._tally.receive(t, t + self._latency)
        self._tally.dropped += len(arrived) - 1
        return self._taken(arrived[-1])

    def taken_at(self, sequence: int) -> float:
        """When the picture that a frame shows was really taken, whatever the frame's stamp says.

        Args:
            sequence: of the frame.

        Returns:
            The moment, middle of the exposure of the middle row [s].
        """
        return self._delivery.shown(sequence) / self._fps

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def _taken(self, number: int) -> Frame:
        """Draw a frame."""
        t = self.taken_at(number)
        image = self._renderer.render(self._world.states(t), t)
        stamp = self._delivery.stamp(number, number / self._fps, 1.0 / self._fps)
        return as_frame(image, stamp, number, "rendered", number / self._fps + self._latency)

    def _newest(self, t: float) -> int:
        """Number of the last picture taken by t."""
        if self._duration is not None:
            t = min(t, self._duration - 2.0 * _SLACK)
        return floor((t + _SLACK) * self._fps)
