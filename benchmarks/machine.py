"""The machine and the versions that figures were measured with."""

import os
import platform
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np


@dataclass(frozen=True, slots=True)
class Machine:
    """What the figures depend on.

    Attributes:
        cpu: model of the processor.
        cores: that this process sees.
        load: average over the last minute, before anything was measured.
        python: version.
        numpy: version.
        opencv: version.
        threads: that every method may use.
    """

    cpu: str
    cores: int
    load: float
    python: str
    numpy: str
    opencv: str
    threads: int

    def sentence(self) -> str:
        """Say it in words.

        Returns:
            One line.
        """
        return (
            f"{self.cpu}, {self.cores} cores, load average {self.load:.2f}; Python {self.python}, "
            f"numpy {self.numpy}, OpenCV {self.opencv}; {self.threads} thread for all"
        )


def describe() -> Machine:
    """Look at the machine.

    Returns:
        Its description.
    """
    return Machine(
        _cpu(),
        os.cpu_count() or 1,
        os.getloadavg()[0],
        platform.python_version(),
        np.__version__,
        cv2.__version__,
        1,
    )


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()
