"""`echelon live` while its camera goes away: all stop; it goes on when it is back, or exits 4."""

import json
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
import typer

from pipeline.cli.output import Output
from pipeline.cli.running import Outputs, Request, run_live
from pipeline.rigs import make_rendered_camera, make_world
from pipeline.scenario import load_scenario
from tests.hardware.streams import MjpegServer

pytestmark = pytest.mark.realtime

PAPER = load_scenario("paper")


class Film:
    """Robots that stand at their start, streamed while it is let."""

    def __init__(self) -> None:
        self._camera = make_rendered_camera(PAPER, make_world(PAPER))
        self.server, self._ended = MjpegServer(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        start = time.monotonic()
        while not self._ended.wait(1 / 30):
            frame = self._camera.latest(time.monotonic() - start)
            if frame is not None:
                self.server.publish(frame.image, 0.0)

    def kill(self) -> None:
        """End the stream and the server."""
        self._ended.set()
        self._thread.join()
        self.server.close()

    def restart(self) -> None:
        """Serve again at the same address."""
        self.server = MjpegServer(port=self.server.port)
        self._ended.clear()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()


def outcome(
    film: Film,
    meanwhile: Callable[[], None],
    duration: float,
    patience: float,
    capsys: pytest.CaptureFixture[str],
) -> tuple[int, dict[str, Any], str]:
    """Exit status, result and what was said of a run while something happens to its camera."""

    def act() -> None:
        while not any(thread.name.startswith("camera http") for thread in threading.enumerate()):
            time.sleep(0.01)
        time.sleep(2.5)
        meanwhile()

    threading.Thread(target=act, daemon=True).start()
    rules = (f"safety.give_up_s={patience}", "camera.latency_s=0.0035")
    request = Request("paper", film.server.url, "none", duration, overrides=rules)
    status = 0
    try:
        run_live(request, Outputs(), Output(True))
    except typer.Exit as end:
        status = end.exit_code
    told = capsys.readouterr()
    return status, json.loads(told.out), told.err


def kinds(result: dict[str, Any]) -> list[str]:
    return [e["kind"] for e in result["safety_events"] if e["kind"].startswith("camera")]


def test_a_camera_that_stays_away_ends_the_run_as_a_safety_stop(
    capsys: pytest.CaptureFixture[str],
) -> None:
    film = Film()
    status, result, told = outcome(film, film.kill, 30.0, 2.0, capsys)
    assert status == 4
    assert kinds(result) == ["camera-silent"]
    assert "it is opened again" in told
    assert "safety stop" in told


def test_a_camera_that_comes_back_lets_the_run_go_on(capsys: pytest.CaptureFixture[str]) -> None:
    film = Film()

    def away_for_a_moment() -> None:
        film.kill()
        time.sleep(0.3)
        film.restart()

    status, result, told = outcome(film, away_for_a_moment, 8.0, 6.0, capsys)
    film.kill()
    assert status == 0
    assert kinds(result) == ["camera-silent", "camera-back"]
    assert "camera: it was lost and came back 1 times" in told
