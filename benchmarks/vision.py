"""Finding robots, beside the floors: copying the frame, packing it and looking colours up."""

from itertools import cycle

import cv2
import numpy as np

from benchmarks.timing import Timed, interleaved
from pipeline.filming import make_renderer
from pipeline.rigs import make_world
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from vision.frame import as_frame
from vision.locate import Prediction, locate

FRAMES, ROUNDS = 16, 300
DOUBT = np.diag([0.004**2, 0.004**2, 0.06**2])  # of a prediction over one frame [m^2, rad^2]


def measure(name: str) -> list[Timed]:
    """Time the search and the tracking of a scenario's robots.

    Args:
        name: of the scenario.

    Returns:
        Floors first.
    """
    scenario = load_scenario(name)
    setup, world, renderer = make_setup(scenario), make_world(scenario), make_renderer(scenario)
    eye, states = setup.eye, world.truth()
    frames = [as_frame(renderer.render(states, k / 30.0), k / 30.0, k) for k in range(FRAMES)]
    known = tuple(Prediction(r.robot_id, r.state.pose, DOUBT) for r in states)
    table = np.zeros(1 << 15, np.uint8)
    turn = cycle(frames)
    size = "{} x {}, {} robots".format(*setup.camera.size_px, len(states))
    copy, packed = f"floor: copy of the frame, {size}", f"floor: pack and look up, {size}"

    def look_up() -> object:
        pack = cv2.cvtColor(next(turn).image, cv2.COLOR_BGR2BGR555).view(np.uint16)
        return table[pack]

    return interleaved(
        [
            (copy, lambda: next(turn).image.copy(), ""),
            (packed, look_up, ""),
            (f"full search, {size}", lambda: locate(next(turn), eye, ()), packed),
            (f"tracked, {size}", lambda: locate(next(turn), eye, known), packed),
        ],
        ROUNDS,
    )
