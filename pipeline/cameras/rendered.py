"""The renderer as a camera: pictures of a simulated world, taken at exact instants."""

from math import floor

from datasets.render import Renderer
from datasets.world import World
from pipeline.ports import EndOfStream
from vision.frame import Frame, as_frame

_SLACK = 1e-9  # a frame is not missed for the rounding of its time [s]


class RenderedCamera:
    """Takes picture n at n / fps and delivers it after the latency; only delivered ones are drawn.

    Attributes:
        dropped: pictures that were passed over because a newer one had arrived.
    """

    def __init__(
        self,
        world: World,
        renderer: Renderer,
        fps: float,
        latency: float,
        duration: float | None = None,
    ) -> None:
        """Look at a world.

        Args:
            world: it is advanced to the present at every call.
            renderer: draws it.
            fps: pictures per second.
            latency: from the picture to its delivery, less than the world remembers (1 s) [s].
            duration: no picture is taken from this time on [s]; None: without end.
        """
        self._world, self._renderer = world, renderer
        self._fps, self._latency, self._duration = fps, latency, duration
        self._next, self.dropped = 0, 0

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
        self.dropped += number - self._next
        self._next = number + 1
        t = number / self._fps
        image = self._renderer.render(self._world.states(t), t)
        return as_frame(image, t, number, "rendered")

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def _newest(self, t: float) -> int:
        """Number of the last picture taken by t."""
        if self._duration is not None:
            t = min(t, self._duration - 2.0 * _SLACK)
        return floor((t + _SLACK) * self._fps)
