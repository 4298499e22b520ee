"""Planes correlated with many kernels: each plane is transformed only once."""

import numpy as np
import scipy
from numpy.typing import NDArray

Singles = NDArray[np.float32]


class Correlator:
    """Correlations of planes with kernels of one size, by Fourier transforms."""

    def __init__(self, planes: Singles, kernel_shape: tuple[int, int]) -> None:
        """Transform the planes; what lies beyond their borders is as at the border.

        Args:
            planes: shape (N, H, W).
            kernel_shape: rows and columns, odd.
        """
        reach = [(n // 2, n // 2) for n in kernel_shape]
        padded = np.pad(planes, [(0, 0), *reach], mode="edge")
        self._rows, self._columns = planes.shape[1:]
        self._size = [scipy.fft.next_fast_len(n, real=True) for n in padded.shape[1:]]
        self._planes = scipy.fft.rfft2(padded, self._size)

    def with_kernel(self, kernel: Singles, count: int | None = None) -> Singles:
        """Correlate.

        Args:
            kernel: of the stated shape.
            count: of the planes, the first ones; all by default.

        Returns:
            Shape (count, H, W), at each place the kernel's middle lies on.
        """
        spectra = self._planes[:count] * np.conj(scipy.fft.rfft2(kernel, self._size))
        whole: Singles = scipy.fft.irfft2(spectra, self._size)
        return whole[:, : self._rows, : self._columns]
