"""What `echelon live` does: connect, observe, run, tell."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter

import typer

from datasets.recorded import SessionHeader, SessionWriter, software_versions
from pipeline.accounts import account, link_reports
from pipeline.cadence import Cadence
from pipeline.camera_model import require_floor
from pipeline.certificate_findings import broken_gains
from pipeline.checks import plan_in_picture
from pipeline.cli.output import Output
from pipeline.config import Scenario
from pipeline.interruption import interruption
from pipeline.live import run
from pipeline.notice import tell
from pipeline.operators.nobody import Nobody
from pipeline.operators.open import open_operator
from pipeline.placing import place_followers
from pipeline.planners.open import open_planner
from pipeline.ports import CommandSink, Observer, Operator
from pipeline.progress import Progress
from pipeline.publishers.open import open_publisher
from pipeline.radios.none import NoRadio
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_scores, make_setup
from pipeline.trajectory import TrajectoryFile
from pipeline.transitions import Transitions

SAFETY_STOP, INTERRUPTED = 4, 130
PATIENCE = 10.0  # for robots that a rendered camera should see at once [s]
NO_SIGNALS = Nobody()
ROOM = 1.5  # a link is asked for commands this much slower than it could carry them


@dataclass(frozen=True, slots=True)
class Request:
    """What `echelon live` was asked for.

    Attributes:
        scenario: name or file.
        camera: SPEC.
        radio: SPEC, None for the camera's default.
        duration: of the run, None: until the mission is finished [s].
        fast: whether time jumps.
        seed: of the rendered world.
        command_period: None for the scenario's [s].
        overrides: "section.key=value" texts.
    """

    scenario: str
    camera: str = "rendered"
    radio: str | None = None
    duration: float | None = None
    fast: bool = False
    seed: int = 0
    command_period: float | None = None
    overrides: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Outputs:
    """What a run is to leave behind.

    Attributes:
        record: session file.
        view: "none", "rerun" or an .rrd file.
        report: folder for figures and page.
        trajectory: CSV file.
        publish: SPEC of where detections go.
    """

    record: Path | None = None
    view: str = "none"
    report: Path | None = None
    trajectory: Path | None = None
    publish: str | None = None

    @property
    def session(self) -> Path | None:
        """The session file: as asked for, or inside the report's folder."""
        return self.record or (self.report / "session.mcap" if self.report else None)


def run_live(
    request: Request, outputs: Outputs, output: Output, signals: Operator = NO_SIGNALS
) -> None:
    """Run a formation and tell the result.

    Args:
        request: what to run.
        outputs: what to leave behind.
        output: where to say it.
        signals: who stops and arms from elsewhere; what was sent before the run counts.

    Raises:
        ConfigError: if the scenario or a SPEC is wrong.
        CameraError: if the camera fails.
        RadioError: if the radio fails.
        Exit: with status 4 after a safety stop, 130 after Ctrl-C.
    """
    scenario = _scenario(request)
    require_floor(scenario.camera, "live")
    spec = (request.camera, request.radio, request.seed, request.fast)
    seeing = ready_to_drive(scenario)  # before robots are connected, whose patience is short
    with interruption() as interrupted, closing(connect(scenario, *spec, interrupted)) as rig:
        scenario = unheard(paced(scenario, rig.sink.min_period, output), rig.sink)
        if request.camera != "rendered":  # a rendered world says where its robots start
            scenario = place_followers(scenario, seeing, rig, output.say, interrupted)
            if interrupted():
                raise typer.Exit(INTERRUPTED)
        setup = make_setup(scenario, seeing)
        for line in _warnings(scenario, setup):
            output.say(f"warning: {line}")
        scores = make_scores(setup)
        seed = request.seed if request.camera == "rendered" else None
        with observers(setup, scenario, seed, request.fast, request.duration, outputs) as others:
            cadence = Cadence(
                scenario.camera.fps, setup.period, tell, partial(link_reports, rig.sink)
            )
            told = Transitions(tell, setup.rules.hold)
            rig = replace(
                rig, observers=(scores, cadence, told, *others),
                operator=open_operator(setup, signals, output.say),
                planner=open_planner(setup, request.fast),
            )  # fmt: skip
            start = perf_counter()
            why = run(setup, rig, setup.period, _end(request, scenario), interrupted)
            wall = perf_counter() - start
    output.result(scores.result(setup.name, wall), cadence.to_json(not request.fast))
    if not request.fast:
        output.cadence(cadence)
    output.links(cadence.links())
    for line in account(rig):
        output.say(line)
    finish(outputs, output)
    if why == "interrupted":
        output.say("interrupted: stop was sent to every robot three times")
        raise typer.Exit(INTERRUPTED)
    if why == "given-up":
        output.say(f"safety stop: the formation had to stand for {setup.rules.give_up:g} s")
        raise typer.Exit(SAFETY_STOP)


@contextmanager
def observers(
    setup: Setup,
    scenario: Scenario,
    seed: int | None,
    lossless: bool,
    duration: float | None,
    outputs: Outputs,
) -> Iterator[list[Observer]]:
    """Open recorder, viewer, trajectory and progress line; what is open is closed whatever happens.

    Args:
        setup: of the run.
        scenario: as it will be recorded.
        seed: of the rendered world, None where there is none.
        lossless: whether the recorder may make the loop wait.
        duration: of the run, None: the scenario's [s].
        outputs: what is wanted.

    Yields:
        The observers.
    """
    with ExitStack() as stack:
        made: list[Observer] = []

        def _keep(observer: Observer) -> None:
            stack.callback(observer.close)
            made.append(observer)

        if outputs.session is not None:
            outputs.session.parent.mkdir(parents=True, exist_ok=True)
            _keep(SessionWriter(outputs.session, header_of(scenario, seed), lossless))
        if outputs.view != "none":
            _keep(_viewer(outputs.view, setup, lossless))
        if outputs.trajectory is not None:
            _keep(TrajectoryFile(outputs.trajectory, setup))
        if outputs.publish is not None:
            _keep(open_publisher(outputs.publish, scenario.radio.team == "yellow"))
        _keep(Progress(duration or scenario.duration_s))
        yield made


def header_of(scenario: Scenario, seed: int | None) -> SessionHeader:
    """What a session says about the run it holds.

    Args:
        scenario: fully resolved.
        seed: of the rendered world, None where there is none.

    Returns:
        The header.
    """
    return SessionHeader(scenario.name, scenario.model_dump_json(), seed, software_versions())


def finish(outputs: Outputs, output: Output) -> None:
    """Write the report that was asked for, and say what lies where.

    Args:
        outputs: what was asked for.
        output: where to say it.
    """
    if outputs.session is not None:
        output.say(f"session: {outputs.session}")
    if outputs.trajectory is not None:
        output.say(f"trajectory: {outputs.trajectory}")
    if outputs.view.endswith(".rrd"):
        viewer = os.path.relpath(Path(sys.executable).with_name("rerun"))
        output.say(f"view: {outputs.view} (look at it with: {viewer} {outputs.view})")
    if outputs.report is not None and outputs.session is not None:
        from pipeline.cli.reporting import write_report

        output.say(f"report: {write_report(outputs.session, outputs.report)}")


def paced(scenario: Scenario, min_period: float, output: Output) -> Scenario:
    """The scenario with a command period that the radio can carry.

    Args:
        scenario: checked scenario.
        min_period: how often the link carries a command for every robot [s].
        output: where a longer period is told.

    Returns:
        The scenario, changed if its period was too short.
    """
    period = ROOM * min_period
    if scenario.control.command_period_s >= period:
        return scenario
    output.say(f"the radio carries a command every {1e3 * period:.1f} ms: the law runs at that")
    control = scenario.control.model_copy(update={"command_period_s": period})
    return scenario.model_copy(update={"control": control})


def unheard(scenario: Scenario, sink: CommandSink) -> Scenario:
    """The scenario of robots that are told nothing: nobody expects them to obey.

    Args:
        scenario: checked scenario.
        sink: where commands go.

    Returns:
        The scenario, changed if they go nowhere.
    """
    if not isinstance(sink, NoRadio):
        return scenario
    safety = scenario.safety.model_copy(update={"unmoved_m": 0.0})
    return scenario.model_copy(update={"safety": safety})


def _scenario(request: Request) -> Scenario:
    changes = list(request.overrides)
    if request.command_period is not None:
        changes.append(f"control.command_period_s={request.command_period}")
    return load_scenario(request.scenario, changes)


def _warnings(scenario: Scenario, setup: Setup) -> Iterator[str]:
    """What will not go well; people may try it all the same."""
    yield from broken_gains(scenario, setup)
    inside = plan_in_picture(setup)
    if inside and not inside.holds:
        yield f"{inside.detail} (robots that are not seen stand, and so do their followers)"


def _end(request: Request, scenario: Scenario) -> float | None:
    """When a run ends at the latest; people may take their time with real robots [s]."""
    if request.duration is None and request.camera == "rendered":
        return scenario.duration_s + PATIENCE
    return request.duration


def _viewer(view: str, setup: Setup, wait: bool) -> Observer:
    from pipeline.viewers.open import open_viewer

    return open_viewer(view, setup, wait)
