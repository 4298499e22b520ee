"""A thread per link: it sends the newest message, keeps the line's budget, and reconnects."""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from pipeline.errors import RadioError
from pipeline.ports import Clock
from pipeline.radios.budget import Budget
from pipeline.radios.link import Link
from pipeline.radios.questions import Questions
from pipeline.radios.report import LinkCounts

LISTEN_PERIOD = 0.02  # replies are looked for at least this often [s]
WATCH_PERIOD, WATCHED = 0.002, 0.2  # and this often for so long after a question [s]
STOPS, STOP_SPACING = 3, 0.01  # one lost burst must not lose all of them [1, s]
FIRST_PAUSE, LONGEST_PAUSE = 0.25, 4.0  # between attempts to reconnect, doubling [s]
RATE_WINDOW = 1.0  # the achieved rate is counted over the last second [s]


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """What is constant about a link.

    Attributes:
        name: its port or address, for messages.
        stop: the message that stops the robot.
        bytes_per_second: what the link carries [B/s].
        question: what a robot answers, None where robots do not answer.
        silence: after so long without a message the robots are stopped, None where they do that
            themselves [s].
    """

    name: str
    stop: bytes
    bytes_per_second: float
    question: bytes | None = None
    silence: float | None = None


class NewestSender:
    """Keeps one link open and one message pending; only calls that are given a timeout wait."""

    def __init__(
        self,
        settings: LinkSettings,
        clock: Clock,
        connect: Callable[[], Link | None],
        hear: Callable[[bytes], None],
    ) -> None:
        """Start the thread, which connects.

        Args:
            settings: name, stop message and budget.
            clock: the run's clock, on which messages go stale.
            connect: opens the link and greets the robot, at every reconnect; raises RadioError;
                None: nobody is there yet, which is no failure.
            hear: takes what the robot answers; called in the link's thread.
        """
        self._settings, self._clock = settings, clock
        self._connect, self._hear = connect, hear
        self._budget, self.questions = Budget(settings.bytes_per_second), Questions()
        self._news = threading.Condition()
        self._pending: tuple[bytes, float] | None = None
        self._stops_left, self._closing, self._up = 0, False, False
        self._moving, self._sent_at = False, 0.0  # whether the last message was no stop; its time
        self._error: RadioError | None = None
        self._sent = self._replaced = self._stale = self._connects = self._failures = 0
        self._silences = 0
        self._recent: deque[float] = deque(maxlen=1000)
        self._thread = threading.Thread(target=self._run, name=settings.name, daemon=True)
        self._thread.start()

    @property
    def up(self) -> bool:
        """Whether the link is connected."""
        return self._up

    @property
    def error(self) -> RadioError | None:
        """Why the link is down, None if it is up."""
        return None if self._up else self._error

    @property
    def counts(self) -> LinkCounts:
        """What became of the messages so far."""
        with self._news:
            since = self._clock.now() - RATE_WINDOW
            rate = sum(t > since for t in self._recent) / RATE_WINDOW
            return LinkCounts(
                self._sent, self._replaced, self._stale, self._connects, self._failures, rate,
                self._silences,
            )  # fmt: skip

    def offer(self, message: bytes, valid_until: float) -> None:
        """Make this the message to be sent next, instead of any that still waits.

        Args:
            message: the bytes.
            valid_until: not sent after this time [s].
        """
        with self._news:
            self._replaced += self._pending is not None
            self._pending = (message, valid_until)
            self._news.notify_all()

    def request_stop(self) -> None:
        """Drop what waits and send stop three times; after a reconnect if the link is down."""
        with self._news:
            self._replaced += self._pending is not None
            self._pending, self._stops_left = None, STOPS
            self._news.notify_all()

    def stopped(self, timeout: float) -> bool:
        """Wait until a requested stop was sent, or cannot be.

        Args:
            timeout: longest wait [s].

        Returns:
            Whether all stops went out.
        """
        with self._news:
            self._news.wait_for(lambda: self._stops_left == 0 or not self._up, timeout)
            return self._stops_left == 0

    def connected(self, timeout: float) -> bool:
        """Wait for the outcome of the first attempt to connect.

        Args:
            timeout: longest wait [s].

        Returns:
            Whether the link is up.
        """
        with self._news:
            self._news.wait_for(lambda: self._up or self._error is not None, timeout)
            return self._up

    def close(self) -> None:
        """Ask the thread to end. Safe to call twice; `ended` waits for it."""
        with self._news:
            self._closing = True
            self._news.notify_all()

    def ended(self, timeout: float) -> bool:
        """Wait for the thread after `close`.

        Args:
            timeout: longest wait [s].

        Returns:
            Whether the link is released.
        """
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            self._keep_connected()
        finally:  # however this thread ends, its link must not look alive
            closed = RadioError(f"radio {self._settings.name}: closed")
            self._go_down(self.error or closed, 0.0)

    def _keep_connected(self) -> None:
        pause = FIRST_PAUSE
        while not self._closing:
            try:
                self._serve_one_connection()
            except RadioError as error:
                pause = FIRST_PAUSE if self._up else min(2.0 * pause, LONGEST_PAUSE)
                self._failures += 1
                self._go_down(error, pause)

    def _serve_one_connection(self) -> None:
        link = self._connect()
        if link is None:
            return
        try:
            self._come_up()
            self._serve(link)
        except RadioError:
            self._last_words(link)
            raise
        finally:
            self.questions.dropped()
            link.close()

    def _serve(self, link: Link) -> None:
        while True:
            message = self._next_message()
            if message is not None:
                link.write(message)
                self._book(message)
            elif self._closing:
                return
            self._ask(link, message)
            self._hear(link.read())

    def _ask(self, link: Link, message: bytes | None) -> None:
        """Ask a question right behind a message, or while the robot stands by the last stop.

        Never else: a robot may take a question for a sign of life, and one whose commands have
        ceased must stop itself.
        """
        question, now = self._settings.question, self._clock.now()
        stopping = message is self._settings.stop or self._stops_left > 0
        busy = self._moving if message is None else False
        if question is None or stopping or busy or not self.questions.due(now):
            return
        if self.questions.silent:  # what it is sent piles up somewhere, and may reach it stale
            raise RadioError(f"radio {self._settings.name}: the robot answers no longer")
        self.questions.asked(now)
        link.write(question)
        with self._news:
            self._budget.spend(len(question), now)

    def _next_message(self) -> bytes | None:
        """Wait for something to send, but not longer than replies may wait."""
        with self._news:
            self._watch_silence(self._clock.now())
            if self._stops_left:
                self._news.wait(STOP_SPACING if self._stops_left < STOPS else 0.0)
                return self._settings.stop
            now = self._clock.now()
            wait, watched = self._budget.wait(now), self.questions.is_out(now, WATCHED)
            listen = WATCH_PERIOD if watched else LISTEN_PERIOD
            if (self._pending is None or wait > 0.0) and not self._closing:
                self._news.wait(min(listen, wait) if self._pending else listen)
            return self._take()

    def _watch_silence(self, now: float) -> None:
        """Stop robots that would drive on when commands cease, as their own deadman would."""
        silence = self._settings.silence
        if silence is not None and self._moving and now - self._sent_at > silence:
            self._stops_left = self._stops_left or STOPS
            self._silences, self._moving = self._silences + 1, False

    def _take(self) -> bytes | None:
        now = self._clock.now()
        if self._pending is None or self._stops_left or self._budget.wait(now) > 0.0:
            return None
        (message, valid_until), self._pending = self._pending, None
        if valid_until < now:
            self._stale += 1
            return None
        return message

    def _book(self, message: bytes) -> None:
        with self._news:
            now = self._clock.now()
            self._budget.spend(len(message), now)
            self._moving, self._sent_at = message is not self._settings.stop, now
            if not self._moving:  # a command may have the same bytes; it is another object
                self._stops_left = max(0, self._stops_left - 1)
                self._news.notify_all()
                return
            self._sent += 1
            self._recent.append(now)

    def _last_words(self, link: Link) -> None:
        """A link that failed may still take a stop once the stale bytes in its way are gone."""
        link.discard()
        try:
            link.write(self._settings.stop)
        except RadioError:
            return  # the robot's own timeout stops it

    def _come_up(self) -> None:
        with self._news:
            self._up, self._connects = True, self._connects + 1
            self._news.notify_all()

    def _go_down(self, error: RadioError, pause: float) -> None:
        with self._news:
            self._up, self._error = False, error
            self._news.notify_all()
            self._news.wait_for(lambda: self._closing, pause)
