"""A session in, a folder with figures and one self-contained page out."""

from pathlib import Path
from typing import TYPE_CHECKING

from datasets.errors import RecordingError
from datasets.recorded import read_session
from pipeline.certificates import make_certificates
from pipeline.report.extras import latencies, seen_picture
from pipeline.report.figures import angular_velocities, linear_velocities, tracking_errors
from pipeline.report.floor import trajectories
from pipeline.report.marks import Marks, marks_of
from pipeline.report.omega import CAPTION, omega_sets, run_errors, run_starts
from pipeline.report.page import Chapter, Summary, page
from pipeline.report.series import Collector, Series
from pipeline.report.style import house_style, png_of
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
    settled = [follower.settled_at_s for follower in result.followers]
    until = float(series.times[-1]) if series.started else 0.0
    marks = marks_of(setup, settled, until)
    with house_style():
        chapters = _chapters(series, setup, marks)
    return _write(out, chapters, Summary(recording.header, recording.end, result, series))


def _chapters(series: Series, setup: Setup, marks: Marks) -> tuple[Chapter, ...]:
    wide = "Wide and pale: true; thin: estimated. " if series.has_truth else "Estimates. "
    marked = "Grey: the leader turns; dashed: formation reached, shape changes."
    return (
        _chapter(
            "fig6_trajectories",
            "Trajectories",
            wide + "Bodies at equal intervals, linked to their leaders; dotted: wanted places.",
            trajectories(series, setup),
        ),
        _chapter(
            "fig7_tracking_errors",
            "Tracking errors, wanted minus actual",
            wide + marked + " Green: in place, within 2 cm and 0.1 rad.",
            tracking_errors(series, marks),
        ),
        _chapter(
            "fig8_linear_velocities",
            "Linear velocities",
            wide + marked,
            linear_velocities(series, marks),
        ),
        _chapter(
            "fig9_angular_velocities",
            "Angular velocities",
            wide + marked,
            angular_velocities(series, marks),
        ),
        _chapter(
            "latency",
            "Latency",
            "Per frame: finding the robots, hand-over to command, capture to the wheels' reaction.",
            latencies(series),
        ),
        _chapter("omega", "Omega, Lambda and the run", CAPTION, _omega(series, setup)),
        Chapter("camera", "What the camera saw", _seen(series), seen_picture(series, setup)),
    )


def _omega(series: Series, setup: Setup) -> "Figure":
    """From the start that the run really had."""
    made = make_certificates(setup, run_starts(series))
    return omega_sets(made, setup, run_errors(series, setup))


def _seen(series: Series) -> str:
    if series.picture is None:
        return "No frame was looked at."
    frame, scene = series.picture
    found, rejected = len(scene.detections), len(scene.rejected)
    return f"Frame {frame.sequence}: {found} robots found, {rejected} candidates rejected (red)."


def _chapter(stem: str, title: str, caption: str, figure: "Figure") -> Chapter:
    return Chapter(stem, title, caption, png_of(figure))


def _write(out: Path, chapters: tuple[Chapter, ...], summary: Summary) -> Path:
    target = out / "report.html"
    try:
        out.mkdir(parents=True, exist_ok=True)
        for chapter in chapters:
            (out / f"{chapter.stem}.png").write_bytes(chapter.png)
        target.write_text(page(summary, chapters), encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error
    return target
