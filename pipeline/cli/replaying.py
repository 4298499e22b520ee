"""What `echelon replay` does, for sessions and for footage."""

from pathlib import Path
from time import perf_counter

import typer

from datasets.recorded import Footage, Session, read_frames, read_session
from pipeline.camera_model import require_floor
from pipeline.cameras.footage import FootageCamera
from pipeline.cli.output import Output
from pipeline.cli.running import INTERRUPTED, Outputs, finish, observers
from pipeline.clock import VirtualClock
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.interruption import interruption
from pipeline.live import Rig, run
from pipeline.radios.none import NoRadio
from pipeline.readiness import ready_to_drive
from pipeline.replay import Difference, replay
from pipeline.scenario import load_scenario, parse_scenario
from pipeline.setup import make_scores, make_setup

DIFFERENT = 5


def replay_session(
    source: Path,
    scenario: str | None,
    overrides: tuple[str, ...],
    compare: bool,
    outputs: Outputs,
    output: Output,
) -> None:
    """Recompute a session tick by tick.

    Args:
        source: the session.
        scenario: name or file to use instead of the session's own, None: its own.
        overrides: changes to the other scenario.
        compare: whether a difference is a failure.
        outputs: what to leave behind.
        output: where to say it.

    Raises:
        ConfigError: if a comparison with another scenario is asked for.
        RecordingError: if the session cannot be read.
        Exit: with status 5 if the commands differ, 130 after Ctrl-C.
    """
    session = read_session(source)
    used = _scenario(session, scenario, overrides, compare)
    setup = make_setup(used, ready_to_drive(used))
    scores, seed = make_scores(setup), session.header.seed
    with interruption() as interrupted, observers(setup, used, seed, True, None, outputs) as others:
        start = perf_counter()
        differences = replay(setup, session, (scores, *others), interrupted)
        wall, stopped = perf_counter() - start, interrupted()
    verdict = {"commands_equal": not differences, "cycles_different": len(differences)}
    output.result(scores.result(setup.name, wall), {} if scenario else verdict)
    finish(outputs, output)
    _tell_end(session, output)
    if not scenario:
        output.say(_verdict(differences))
    if stopped:
        raise typer.Exit(INTERRUPTED)
    if compare and differences:
        raise typer.Exit(DIFFERENT)


def _scenario(
    session: Session, name: str | None, overrides: tuple[str, ...], compare: bool
) -> Scenario:
    """The session's own scenario, or another one to ask what would have been."""
    if (name or overrides) and compare:
        raise ConfigError("--compare needs the session's own scenario, without --set")
    if overrides and not name:
        raise ConfigError("--set needs a SCENARIO: the session's own is replayed as it was")
    return load_scenario(name, overrides) if name else parse_scenario(session.header.scenario)


def _tell_end(session: Session, output: Output) -> None:
    """Say what the recorder did not keep."""
    if not session.end.complete:
        output.say(f"{session.path}: the recording was cut off; all that was written was replayed")
    if session.end.dropped:
        output.say(f"{session.path}: the recorder had dropped {session.end.dropped} cycles")


def replay_footage(
    source: Path,
    scenario: str,
    overrides: tuple[str, ...],
    fps: float | None,
    outputs: Outputs,
    output: Output,
) -> None:
    """Look at a video or a folder frame by frame, as the live loop would.

    Args:
        source: video file or folder of images.
        scenario: name or file.
        overrides: changes to it.
        fps: constant frame rate instead of the video's own times; None: those, 30 for a folder.
        outputs: what to leave behind.
        output: where to say it.

    Raises:
        ConfigError: if the scenario is wrong or the frames have another size.
        RecordingError: if the footage cannot be read.
        Exit: with status 130 after Ctrl-C.
    """
    used = load_scenario(scenario, overrides)
    require_floor(used.camera, "replay")
    setup, footage = make_setup(used, ready_to_drive(used)), read_frames(source, fps)
    scores = make_scores(setup)
    camera = FootageCamera(footage, used.camera.latency_s)
    with interruption() as interrupted, observers(setup, used, None, True, None, outputs) as others:
        rig = Rig(camera, NoRadio(), VirtualClock(), observers=(scores, *others))
        start = perf_counter()
        why = run(setup, rig, setup.period, None, interrupted)
        wall = perf_counter() - start
    output.result(scores.result(setup.name, wall))
    _tell_losses(footage, output)
    finish(outputs, output)
    if why == "interrupted":
        raise typer.Exit(INTERRUPTED)


def _tell_losses(footage: Footage, output: Output) -> None:
    if footage.lost:
        output.say(f"{footage.path}: {footage.lost} announced frames could not be decoded")


def _verdict(differences: tuple[Difference, ...]) -> str:
    if not differences:
        return "every recomputed command equals the recorded one, bit for bit"
    first = differences[0]
    return (
        f"commands differ in {len(differences)} cycles, first at {first.t:.3f} s: "
        f"recorded {first.recorded}, recomputed {first.recomputed}"
    )
