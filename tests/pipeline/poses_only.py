"""The loop of `live` with the poses of a simulated run: the first pixels are their bytes."""

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D
from datasets.cycle import Moment, RobotState, Tick, Timing
from datasets.truth import RunResult
from pipeline.cameras.rendered import RenderedCamera
from pipeline.filming import make_delivery
from pipeline.live import ENDS
from pipeline.memory import Memory
from pipeline.radios.simulated import SimulatedRadio
from pipeline.rigs import make_world
from pipeline.setup import make_scores
from pipeline.simulation.draw import Drawn
from pipeline.simulation.experiment import Experiment
from pipeline.step import step
from vision.detector import Detector
from vision.frame import Frame
from vision.light import PALETTE_LIGHT, Light
from vision.locate import Prediction
from vision.scene import Detection, PixelPose, Scene

TIMING, PIXEL = Timing(0.0, 0.0, 0.0), PixelPose(0.0, 0.0, 0.0)


class PosesOnly:
    """Renders the poses of robots with the errors of a simulated run, and reads them again."""

    def __init__(self, experiment: Experiment, drawn: Drawn) -> None:
        self._experiment, camera = experiment, experiment.scenario.camera
        frames, noise = drawn.timetables[0].frames, drawn.chance.noise[0]
        self._errors = dict(zip(frames.taken.tolist(), noise, strict=False))
        self._shape = camera.height_px, camera.width_px, 3

    def render(self, states: tuple[RobotState, ...], t: float) -> NDArray[np.uint8]:
        true = {robot.robot_id: robot.state for robot in states}
        robots = [true[plant.robot_id] for plant in self._experiment.plants]
        poses = np.array([(s.x, s.y, s.theta) for s in robots])
        poses += self._errors.get(t, np.zeros(3))
        image = np.zeros(self._shape, np.uint8)
        image.reshape(-1)[: poses.nbytes] = np.frombuffer(poses.tobytes(), np.uint8)
        return image

    def locate(
        self, detector: Detector, frame: Frame, expected: tuple[Prediction, ...], light: Light
    ) -> Scene:
        del detector, expected, light
        count = 3 * len(self._experiment.plants)
        poses = np.frombuffer(frame.image.tobytes(), np.float64, count).reshape(-1, 3).tolist()
        covariance = np.diag(self._experiment.pose_std**2)
        seen = tuple(
            Detection(plant.robot_id, Pose2D(*pose), PIXEL, covariance, 0.0, 1.0)
            for plant, pose in zip(self._experiment.plants, poses, strict=True)
        )
        return Scene(frame.t_capture, seen, (), PALETTE_LIGHT)


def run_in_python(
    experiment: Experiment, drawn: Drawn, seed: int
) -> tuple[RunResult, list[Moment]]:
    """The run of a seed by `pipeline.step`, its scores and all its moments."""
    scenario, setup = experiment.scenario, experiment.setup
    world, eye = make_world(scenario, seed), PosesOnly(experiment, drawn)
    c, r = scenario.camera, scenario.radio
    camera = RenderedCamera(world, eye, c.fps, c.latency_s, None, make_delivery(c, seed))  # type: ignore[arg-type]
    radio = SimulatedRadio(world, r.delay_s, r.loss, None, seed)
    memory, scores, moments = Memory(), make_scores(setup), list[Moment]()
    for number in range(experiment.ticks):
        tick = Tick(number * setup.period, camera.latest(number * setup.period))
        memory, cycle = step(setup, memory, tick, eye.locate)
        radio.send(cycle.commands, tick.t)
        moments.append(Moment(tick, cycle, world.truth(), TIMING))
        scores.observe(moments[-1])
        if cycle.phase in ENDS:
            break
    return scores.result(setup.name, 0.0), moments
