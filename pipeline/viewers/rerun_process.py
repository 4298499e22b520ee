"""The helper process of the Rerun view: reads moments from its standard input and draws them."""

import os
import pickle
import shutil
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.viewers.blueprint import run_blueprint
from pipeline.viewers.rerun_plots import RerunPlots
from pipeline.viewers.rerun_scene import RerunScene
from pipeline.viewers.stage import Stage

if TYPE_CHECKING:
    import rerun

_PORT = 9876
_OPEN_LIMIT = 8.0  # [s]
_CHECK_EVERY = 30  # moments
_CHECK_LIMIT = 3.0  # [s]


def main() -> None:
    """Draw until the input ends or the viewer is gone."""
    messages, answers = sys.stdin.buffer, sys.stdout
    mode, stage = pickle.load(messages)
    try:
        recording = _open(mode, stage)
    except Exception as error:  # noqa: BLE001 (whatever it is, the parent shows it as one line)
        print(str(error).replace("\n", " "), file=answers, flush=True)
        return
    print("ready", file=answers, flush=True)
    # a viewer decodes pictures late, behind the outlines drawn on them; a file is to be small
    scene = RerunScene(recording, stage, compressed=mode != "rerun")
    drawers = (scene, RerunPlots(recording, stage))
    count = 0
    while (moment := pickle.load(messages)) is not None:
        recording.set_time("time", duration=moment.tick.t)
        for drawer in drawers:
            drawer.draw(moment)
        count += 1
        if count % _CHECK_EVERY == 0:
            # A viewer that was closed would have everything pile up in memory: this raises.
            recording.flush(timeout_sec=_CHECK_LIMIT)
    recording.flush(timeout_sec=_CHECK_LIMIT)


def _open(mode: str, stage: Stage) -> "rerun.RecordingStream":
    """Connect to a viewer, opening one if needed, or create the file."""
    import rerun

    recording = rerun.RecordingStream("echelon")
    blueprint = run_blueprint(stage)
    if mode != "rerun":
        recording.save(mode, default_blueprint=blueprint)
        return recording
    if not _is_open(_PORT):
        _open_window(recording)
    recording.connect_grpc(f"rerun+http://127.0.0.1:{_PORT}/proxy", default_blueprint=blueprint)
    recording.flush(timeout_sec=_OPEN_LIMIT)
    return recording


def _open_window(recording: "rerun.RecordingStream") -> None:
    """Start the viewer that was installed with this program; it outlives the run."""
    import rerun

    if sys.platform == "linux" and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))):
        raise RuntimeError("there is no screen; use --view FILE.rrd and open the file elsewhere")
    beside = Path(sys.executable).with_name("rerun")
    rerun.spawn(
        port=_PORT,
        connect=False,
        hide_welcome_screen=True,
        executable_path=str(beside) if beside.exists() else shutil.which("rerun"),
        recording=recording,
    )


def _is_open(port: int) -> bool:
    """Tell whether a viewer listens already, here or at the other end of a tunnel."""
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


if __name__ == "__main__":
    main()
