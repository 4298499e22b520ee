"""Figures beyond the paper's: computing times, and what the camera saw."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.series import Floats, Series
from pipeline.report.style import color_of, new_figure, say_empty
from pipeline.setup import Setup
from pipeline.viewers.stage import name_of, placed
from vision.frame import Frame
from vision.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
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


def picture(series: Series, setup: Setup) -> "Figure":
    """The frame with the most robots, with what was accepted and rejected.

    Args:
        series: of the run.
        setup: camera and tags.

    Returns:
        The picture.
    """
    figure, (axes,) = new_figure(5.4)
    if series.picture is None:
        say_empty(axes, "no frame was looked at")
        return figure
    frame, scene = series.picture
    axes.imshow(frame.image[:, :, ::-1], interpolation="nearest")
    axes.grid(visible=False)
    _draw_found(axes, frame, scene, series, setup)
    for rejection in scene.rejected:
        axes.plot(rejection.x, rejection.y, "x", ms=6, color="#ff5050", mew=1.2)
    axes.set_xlabel("x  [px]")
    axes.set_ylabel("y  [px]")
    text = f"frame {frame.sequence}: {len(scene.detections)} robots, {len(scene.rejected)} rejected"
    axes.set_title(f"{text} (red crosses)" if scene.rejected else text, fontsize=9.5)
    return figure


def _draw_found(axes: "Axes", frame: Frame, scene: Scene, series: Series, setup: Setup) -> None:
    camera = setup.eye_for(frame.size_px).camera
    outlines = {tag.robot_id: tag.parts[0].polygon for tag in setup.tags.tags}
    for detection in scene.detections:
        robot_id = detection.robot_id
        index = series.robots.index(robot_id) if robot_id in series.robots else 0
        corners: Floats = placed(outlines[robot_id], detection.pose)
        height = np.full((len(corners), 1), camera.tag_height)
        pixels = camera.project(np.hstack((corners, height)))
        axes.fill(*pixels.T, fill=False, ec=color_of(index) if index else "white", lw=1.4)
        axes.text(
            detection.pixel.x,
            pixels[:, 1].min() - 0.015 * frame.size_px[1],
            name_of(robot_id),
            color="white",
            fontsize=9,
            fontweight="bold",
            ha="center",
        )
