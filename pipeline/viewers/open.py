"""From the option --view to a viewer."""

import numpy as np

from pipeline.errors import ConfigError
from pipeline.ports import Observer
from pipeline.setup import Setup
from pipeline.viewers.rerun import RerunViewer
from pipeline.viewers.stage import Stage

_STEP = 0.02  # between drawn points of the path [s]


def stage_of(setup: Setup) -> Stage:
    """What a viewer draws of a setup.

    Args:
        setup: of the run.

    Returns:
        Its fixed things, robots in the order of the formation.
    """
    times = np.arange(0.0, setup.duration + _STEP, _STEP).tolist()
    states = [setup.path.at(t).state for t in times] if setup.path else []
    path = np.array([(state.x, state.y) for state in states]).reshape(-1, 2)
    order = setup.formation.robots
    tags = sorted(
        setup.tags.tags, key=lambda tag: order.index(tag.robot_id) if tag.robot_id in order else 99
    )
    discs = setup.errand.obstacles if setup.errand else ()
    return Stage(
        setup.camera, tuple(tags), setup.follower.camera_offset, path,
        tuple((o.x, o.y, o.radius) for o in discs), setup.worn,
    )  # fmt: skip


def open_viewer(view: str, setup: Setup, wait: bool = False) -> Observer:
    """Open a viewer.

    Args:
        view: "rerun", or the path of an .rrd file.
        setup: of the run.
        wait: hold the run up instead of dropping what cannot be drawn in time.

    Returns:
        The viewer.

    Raises:
        ConfigError: if it cannot be opened, or the name is no .rrd file's.
        RecordingError: if the file cannot be written.
    """
    if view != "rerun" and not view.endswith(".rrd"):
        raise ConfigError(f"--view {view}: need none, rerun or FILE.rrd")
    return RerunViewer(view, stage_of(setup), wait)
