"""The safety filter as machine code: an idle call costs 20 us, a busy one 0.1 ms; 20 in Python."""

import numpy as np

from control import safety
from control.safety import Arena, Clearance
from pipeline.notice import told_after
from vision.compiled import compiled

PATIENCE = 2.0  # of a user who is told nothing [s]

keep_apart = compiled(safety.keep_apart)


def rehearse_clearing() -> None:
    """Compile the filter, or load it from disk, so that no command waits for it."""
    with told_after(PATIENCE, "compiling the safety filter for this processor, this once"):
        twists = np.zeros((2, 2))
        keep_apart(np.zeros((2, 3)), twists, twists, twists, np.zeros(2), Clearance(), Arena())
