"""Figures beyond the paper's: computing times, and what the camera saw."""

from typing import TYPE_CHECKING

import cv2
import numpy as np

from pipeline.report.series import Series
from pipeline.report.style import new_figure, say_empty
from pipeline.setup import Setup
from pipeline.viewers.overlay import draw_scene
from pipeline.viewers.reasons import with_reasons

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TIMES = (
    (3, "vision", "#56B4E9"),
    (5, "frame to command", "#E69F00"),
    (6, "capture to wheels", "#8a8f98"),
)


def latencies(series: Series) -> "Figure":
    """Histograms of what a frame costs and how old it is when it acts.

    Args:
        series: of the run.

    Returns:
        One plot with a logarithmic time axis.
    """
    figure, (axes,) = new_figure(3.2)
    values = [(1e3 * series.frames[:, column], name, color) for column, name, color in _TIMES]
    positive = [v[np.isfinite(v) & (v > 0.0)] for v, _, _ in values]
    if not any(map(len, positive)):
        say_empty(axes, "no frames")
    else:
        every = np.concatenate(positive)
        edges = np.geomspace(0.9 * every.min(), 1.1 * every.max(), 60).tolist()
        for times, (_, name, color) in zip(positive, values, strict=True):
            if len(times):
                text = (
                    f"{name}: median {np.median(times):.1f}, 99 % {np.percentile(times, 99):.1f} ms"
                )
                axes.hist(times, edges, color=color, alpha=0.75, label=text)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.legend()
    axes.set_xlabel("time  [ms]")
    axes.set_ylabel("frames")
    return figure


def seen_picture(series: Series, setup: Setup) -> bytes:
    """A frame with the most robots, with what was accepted and rejected.

    Args:
        series: of the run.
        setup: camera and tags.

    Returns:
        A PNG; a plain grey one if no frame was looked at.
    """
    image = np.full((60, 640, 3), 200, np.uint8)
    if series.picture is not None:
        frame, scene = series.picture
        camera = setup.seeing.detector_for(frame.size_px).camera
        image = with_reasons(draw_scene(frame.image, scene, setup.tags, camera), scene)
    return cv2.imencode(".png", image)[1].tobytes()
