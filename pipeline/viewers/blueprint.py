"""The one layout of the Rerun view: what happens on the left, how well on the right."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.viewers.stage import Stage

if TYPE_CHECKING:
    import rerun.blueprint as rrb

GROUND = (16, 18, 24)  # of both pictures, dark
_PLOTS = (
    ("distance_error", "Distance error, wanted minus predicted  [mm]"),
    ("bearing_error", "Bearing error, wanted minus predicted  [deg]"),
    ("speed", "Forward speed, dim: commanded  [m/s]"),
    ("turn_rate", "Turn rate, dim: commanded  [rad/s]"),
    ("latency", "Latency  [ms]"),
)


def run_blueprint(stage: Stage) -> "rrb.Blueprint":
    """Lay the views out.

    Args:
        stage: whose field is zoomed to.

    Returns:
        Two columns: floor and camera; plots and events.
    """
    import rerun.blueprint as rrb

    corners = stage.field() * (1.0, -1.0)  # Rerun's y points down
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.03 * float(np.max(high - low))
    bounds = rrb.VisualBounds2D(
        x_range=(low[0] - margin, high[0] + margin), y_range=(low[1] - margin, high[1] + margin)
    )
    whole_past = rrb.VisibleTimeRanges(
        timeline="time",
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    floor = rrb.Spatial2DView(
        origin="/floor",
        name="Floor, seen from above  (grid 0.5 m)",
        background=GROUND,
        visual_bounds=bounds,
        overrides={"/floor/track": whole_past},
    )
    width, height = stage.camera.size_px
    picture = rrb.VisualBounds2D(x_range=(0.0, float(width)), y_range=(0.0, float(height)))
    camera = rrb.Spatial2DView(
        origin="/camera", name="Camera  [px]", background=GROUND, visual_bounds=picture
    )
    plots = [_plot(name, title) for name, title in _PLOTS]
    log = rrb.TextLogView(
        origin="/events",
        name="Phases and safety events",
        columns=rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"]),
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(floor, camera, row_shares=[1, 1]),
            rrb.Vertical(*plots[:-1], rrb.Horizontal(plots[-1], log)),
            column_shares=[5, 6],
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="following"),
    )


def _plot(name: str, title: str) -> "rrb.TimeSeriesView":
    import rerun.blueprint as rrb

    limits = {"latency": (0.0, 100.0)}  # the first cycle, slow by imports, must not set the scale

    return rrb.TimeSeriesView(
        origin=f"/plots/{name}",
        name=title,
        axis_y=rrb.ScalarAxis(range=limits.get(name)),
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        plot_legend=rrb.PlotLegend("RightTop", visible="commanded" not in title),
    )
