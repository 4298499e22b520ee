"""What `echelon check --out` does: a picture of Omega, Lambda and the paths through them."""

from collections.abc import Mapping
from pathlib import Path

from control.command import RobotId
from datasets.recorded import read_session
from pipeline.certificates import make_certificates, start_states
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.report.omega import omega_sets, run_errors
from pipeline.report.series import Collector, Floats
from pipeline.report.style import house_style, png_of
from pipeline.scenario import parse_scenario
from pipeline.setup import Setup, make_setup


def write_omega(scenario: Scenario, out: Path, session: Path | None) -> Path:
    """Draw Omega and Lambda of every follower.

    Args:
        scenario: checked.
        out: folder, made if missing.
        session: a run whose path is drawn too.

    Returns:
        The picture.

    Raises:
        ConfigError: if the scenario cannot be driven, the session is of another formation, or the
            folder cannot be written.
        RecordingError: if the session cannot be read.
    """
    setup = make_setup(scenario)
    runs = {} if session is None else _runs(session, setup)
    with house_style():
        made = make_certificates(setup, start_states(scenario, setup))
        picture = png_of(omega_sets(made, setup, runs))
    target = out / "omega.png"
    try:
        out.mkdir(parents=True, exist_ok=True)
        target.write_bytes(picture)
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror})") from error
    return target


def _runs(session: Path, setup: Setup) -> Mapping[RobotId, Floats]:
    """Errors of a session by follower."""
    recording = read_session(session)
    theirs = make_setup(parse_scenario(recording.header.scenario)).formation
    if [(p.leader, p.follower) for p in theirs.pairs] != [
        (p.leader, p.follower) for p in setup.formation.pairs
    ]:
        raise ConfigError(f"{session}: its formation is not that of scenario {setup.name}")
    collector = Collector(setup)
    for moment in recording:
        collector.observe(moment)
    return run_errors(collector.series(), setup)
