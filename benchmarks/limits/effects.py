"""Every effect at three strengths, through the whole loop."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

from benchmarks.limits.errors import Errors
from benchmarks.limits.strengths import EFFECTS, Effect
from datasets.cycle import Moment
from datasets.scores import FollowerScore
from datasets.sightings import VisionScore
from datasets.world import World
from pipeline.cameras.rendered import RenderedCamera
from pipeline.clock import VirtualClock
from pipeline.live import Rig, run
from pipeline.radios.simulated import SimulatedRadio
from pipeline.rigs import make_rendered_camera, make_world
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_scores, make_setup
from vision.light import PALETTE_LIGHT

EVERY = 5  # so many frames apart, one is also searched from nothing
PATIENCE = 4.0  # beyond the scenario's duration, for robots not seen at once [s]


@dataclass(frozen=True, slots=True)
class Row:
    """One effect at one strength.

    Attributes:
        effect: its name.
        strength: with its unit.
        searched: single frames of the run, searched from nothing.
        seen: in the loop, which tracks.
        distance_mm: rms of the worst follower over the last 20 % of the run; NaN if it did not
            finish.
        bearing_deg: the same of its bearing.
        events: of safety.
        end: why the run ended.
    """

    effect: str
    strength: str
    searched: Errors
    seen: VisionScore
    distance_mm: float
    bearing_deg: float
    events: int
    end: str


class Sampler:
    """An observer that searches some frames from nothing, with the robots where they truly were."""

    def __init__(self, setup: Setup, world: World, camera: RenderedCamera) -> None:
        """Start with nothing seen.

        Args:
            setup: of the run.
            world: knows the truth.
            camera: knows when its pictures were really taken.
        """
        self._setup, self._world, self._camera = setup, world, camera
        self.errors = Errors(setup.tags.tags[0].side)

    def observe(self, moment: Moment) -> None:
        """Search a frame if it is its turn.

        Args:
            moment: the cycle.
        """
        frame = moment.tick.frame
        if frame is not None and frame.sequence % EVERY == 0:
            truth = self._world.states(self._camera.taken_at(frame.sequence))
            self.errors.add(self._setup.seeing.detector.locate(frame, (), PALETTE_LIGHT), truth)

    def close(self) -> None:
        """Keep everything. Safe to call twice."""


def rows() -> Iterator[Row]:
    """Run effect after effect, always the same.

    Yields:
        Three rows per effect.
    """
    for effect in EFFECTS:
        for strength, overrides in effect.steps:
            yield _measured(effect, strength, overrides)


def count() -> int:
    """How many rows there are.

    Returns:
        Their number.
    """
    return sum(len(effect.steps) for effect in EFFECTS)


def _measured(effect: Effect, strength: str, overrides: tuple[str, ...]) -> Row:
    scenario = load_scenario("paper", overrides)
    setup, world = make_setup(scenario), make_world(scenario)
    camera = make_rendered_camera(scenario, world)
    sampler, scores = Sampler(setup, world, camera), make_scores(setup)
    radio = SimulatedRadio(world, scenario.radio.delay_s)
    rig = Rig(camera, radio, VirtualClock(), world.truth, (scores, sampler))
    end = run(setup, rig, setup.period, scenario.duration_s + PATIENCE)
    result = scores.result(effect.name, 0.0)
    seen = result.vision or VisionScore(0.0, 0, None, None)
    distance, bearing = _worst(result.followers if end == "finished" else ())
    events = len(result.safety_events)
    return Row(effect.name, strength, sampler.errors, seen, distance, bearing, events, end)


def _worst(followers: tuple[FollowerScore, ...]) -> tuple[float, float]:
    """Largest distance rms [mm] and bearing rms [deg]; NaN if there is none."""
    nan = float("nan")
    distances = [f.distance_rms_m for f in followers if f.distance_rms_m is not None]
    bearings = [f.bearing_rms_rad for f in followers if f.bearing_rms_rad is not None]
    return 1e3 * max(distances, default=nan), degrees(max(bearings, default=nan))
