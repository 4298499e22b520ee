"""What `echelon report` does: a session in, figures and a page out."""

from pathlib import Path

from datasets.recorded import read_session
from pipeline.scenario import parse_scenario
from pipeline.setup import make_setup


def write_report(session: Path, out: Path) -> Path:
    """Draw the figures and the page of a session.

    Args:
        session: the recorded file.
        out: folder, made if missing.

    Returns:
        The page.

    Raises:
        RecordingError: if the session cannot be read or the report not written.
        ConfigError: if the session's scenario is of another version.
    """
    from pipeline.report.make import make_report

    setup = make_setup(parse_scenario(read_session(session).header.scenario))
    return make_report(session, out, setup)
