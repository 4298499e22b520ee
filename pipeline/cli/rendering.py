"""What `echelon render` does: the closed loop, with every frame and its truth kept."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from datasets.cycle import Cycle, Moment, Tick, Timing
from datasets.recorded import TruthWriter
from datasets.world import World
from pipeline.camera_model import make_camera
from pipeline.cameras.rendered import RenderedCamera
from pipeline.clock import VirtualClock
from pipeline.interruption import interruption
from pipeline.live import Rig, run
from pipeline.ports import EndOfStream
from pipeline.progress import Progress
from pipeline.radios.simulated import SimulatedRadio
from pipeline.rigs import make_rendered_camera, make_world
from pipeline.scenario import load_scenario
from pipeline.setup import is_undriven, make_setup


class FramesWithTruth:
    """An observer that keeps every frame with the true poses at its capture."""

    def __init__(self, writer: TruthWriter, world: World, camera: RenderedCamera) -> None:
        """Start with nothing written.

        Args:
            writer: of pictures and truth.
            world: knows the truth.
            camera: knows when its pictures were really taken.
        """
        self._writer, self._world, self._camera, self.count = writer, world, camera, 0

    def observe(self, moment: Moment) -> None:
        """Keep a new frame.

        Args:
            moment: the cycle.
        """
        frame = moment.tick.frame
        if frame is not None:
            t = self._camera.taken_at(frame.sequence)
            self._writer.write(replace(frame, t_capture=t), self._world.states(t))
            self.count += 1

    def close(self) -> None:
        """Finish the files. Safe to call twice."""
        self._writer.close()


def render_run(
    name: str, overrides: tuple[str, ...], out: Path, duration: float | None, seed: int
) -> None:
    """Render a scenario's run.

    Args:
        name: of the scenario, or a file.
        overrides: "section.key=value" texts.
        out: video file or folder.
        duration: of the rendered footage, None: the scenario's [s].
        seed: of the rendered world.

    Raises:
        ConfigError: if the scenario is wrong.
        RecordingError: if the files cannot be written.
    """
    scenario = load_scenario(name, overrides)
    setup = None if is_undriven(scenario) else make_setup(scenario)
    world, c = make_world(scenario, seed), scenario.camera
    seconds = scenario.duration_s if duration is None else duration
    camera = make_rendered_camera(scenario, world, seed, seconds)
    radio = SimulatedRadio(world, scenario.radio.delay_s, seed=seed)
    frames = FramesWithTruth(TruthWriter(out, c.fps, make_camera(c)), world, camera)
    rig = Rig(camera, radio, VirtualClock(), world.truth, (frames, Progress(seconds)))
    with interruption() as interrupted:
        if setup is None:
            _stand(rig, 0.5 / c.fps, interrupted)
        else:
            run(setup, rig, setup.period, seconds + c.latency_s + 1.0, interrupted)
    print(f"{frames.count} frames: {out}", file=sys.stderr)  # noqa: T201 (what was asked for)


def _stand(rig: Rig, period: float, interrupted: Callable[[], bool]) -> None:
    """Film robots that nobody drives, until the last frame is taken."""
    try:
        while not interrupted():
            now = rig.clock.now()
            tick = Tick(now, rig.source.latest(now))
            cycle = Cycle(now, now, "standing", None, None, (), (), None, ())
            for observer in rig.observers:
                observer.observe(Moment(tick, cycle, rig.truth(), Timing(0.0, 0.0, 0.0)))
            rig.clock.wait_until(now + period)
    except EndOfStream:
        return
    finally:
        rig.close()
