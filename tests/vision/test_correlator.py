"""Correlating by transforms is correlating: as OpenCV does it place by place, borders included."""

import cv2
import numpy as np
import pytest

from vision.calibration.correlator import Correlator


@pytest.mark.parametrize("shape", [(40, 57), (64, 30), (9, 9)])
@pytest.mark.parametrize("kernel_shape", [(9, 9), (5, 11), (1, 1)])
def test_every_plane_is_correlated(shape: tuple[int, int], kernel_shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    planes = rng.uniform(-100.0, 100.0, (3, *shape)).astype(np.float32)
    kernel = rng.uniform(-1.0, 1.0, kernel_shape).astype(np.float32)
    wanted = [cv2.filter2D(p, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE) for p in planes]
    correlator = Correlator(planes, kernel_shape)
    assert correlator.with_kernel(kernel) == pytest.approx(np.array(wanted), abs=5e-3)
    assert correlator.with_kernel(kernel, 2) == pytest.approx(np.array(wanted[:2]), abs=5e-3)
