"""A session in, a folder with figures and one self-contained page out."""

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from datasets.errors import RecordingError
from datasets.recorded import read_session
from pipeline.report.extras import latencies, picture
from pipeline.report.figures import angular_velocities, linear_velocities, tracking_errors
from pipeline.report.floor import trajectories
from pipeline.report.marks import changes, reconfiguration, turns
from pipeline.report.page import Chapter, Summary, write_page
from pipeline.report.series import Collector
from pipeline.setup import Setup, make_scores

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def make_report(session: Path | str, out: Path | str, setup: Setup) -> Path:
    """Draw the figures and write the page of a session.

    Args:
        session: the recorded file.
        out: folder for ``report.html`` and the PNGs, made if missing.
        setup: made from the session's scenario.

    Returns:
        The page.

    Raises:
        RecordingError: if the session cannot be read or the report not written.
    """
    recording, out = read_session(session), Path(out)
    collector, scores = Collector(setup), make_scores(setup)
    for moment in recording:
        collector.observe(moment)
        scores.observe(moment)
    series = collector.series()
    result = scores.result(recording.header.name, float("nan"))
    spans, instants = turns(setup.path, setup.duration), changes(setup)
    if not series.started:
        spans, instants = (), ()
    opening = reconfiguration(follower.settled_at_s for follower in result.followers)
    drawn = (
        ("fig6_trajectories", trajectories(series, setup)),
        (
            "fig7_tracking_errors",
            tracking_errors(series, spans, (*opening_ends(opening), *instants)),
        ),
        ("fig8_linear_velocities", linear_velocities(series, spans, instants)),
        ("fig9_angular_velocities", angular_velocities(series, spans, instants)),
        ("latency", latencies(series)),
        ("camera", picture(series, setup)),
    )
    return out


"""  """
