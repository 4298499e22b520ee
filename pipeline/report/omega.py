"""Omega and Lambda of every follower in the plane of its errors, with the paths of runs in them."""

from typing import TYPE_CHECKING

import numpy as np

from control.gains import Certificate
from pipeline.certificates import Certificates, Certified
from pipeline.report.series import Floats
from pipeline.report.style import GREY, color_of, new_grid, say_empty
from pipeline.setup import Setup
from pipeline.viewers.stage import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNITS = np.array([1e3, np.degrees(1.0)])  # mm, deg
COLUMNS = 2
INK, FILL = "#5a6068", "#eef1f5"
