"""The lens from many views of a board: start, choice of terms, mistaken corners, checks."""

from collections.abc import Sequence
from dataclasses import replace
from math import log

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.board import Board
from vision.calibration.bundle import LENS, POSE, Fit, Problem, Seen, State, adjust
from vision.calibration.detect import BoardView
from vision.errors import VisionError

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

FOLDS = 5
_LADDER = {
    "no distortion": (),
    "k1": (4,),
    "k1, k2": (4, 5),
    "k1, k2, p1, p2": (4, 5, 6, 7),
    "k1, k2, p1, p2, k3": (4, 5, 6, 7, 8),
}
_GROSS = 5.0  # a corner further off than this many robust standard deviations is mistaken
_GROSS_PX = 0.25  # nearer than this no corner is mistaken [px]
_NO_LENS = np.zeros(LENS, np.bool_)


def seen_on(board: Board, view: BoardView) -> Seen:
    """A view as the fit takes it.

    Args:
        board: that was seen.
        view: of it.

    Returns:
        Points of the board beside their pixels.
    """
    return Seen(view.points(board), view.pixels)


def first_guess(seen: Sequence[Seen], size_px: tuple[int, int]) -> State:
    """A first guess of lens and poses by OpenCV's calibration.

    Args:
        seen: views of a flat board.
        size_px: width and height of the image [px].

    Returns:
        The lens and a pose for every view, without a floor.

    Raises:
        VisionError: if the views do not belong to one camera.
    """
    points = [s.points.astype(np.float32) for s in seen]
    pixels = [s.pixels.astype(np.float32).reshape(-1, 1, 2) for s in seen]
    flags = cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
    try:
        _, matrix, distortion, turns, ways = cv2.calibrateCamera(
            points, pixels, size_px, np.eye(3), np.zeros(5), flags=flags
        )
    except cv2.error as error:
        raise VisionError(f"the views fit no camera ({error.err})") from None
    lens = np.concatenate(
        ((matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]), np.ravel(distortion)[:5])
    )
    poses = np.hstack((np.reshape(turns, (-1, 3)), np.reshape(ways, (-1, 3))))
    held = np.asarray(poses, np.float64)
    if not (np.isfinite(lens).all() and np.isfinite(held).all()):
        raise VisionError("the views fit no camera: take more pictures, with the board tilted")
    return State(lens, held, np.zeros(POSE), np.zeros((0, 3)))


def choose_terms(problem: Problem, start: State) -> tuple[Fit, Problem, str]:
    """Fit lens models of growing order and keep the one the data pay for.

    Args:
        problem: what was seen; its terms are replaced.
        start: first guess.

    Returns:
        The fit with the least Bayesian information criterion, its problem and the terms' names.
    """
    best: tuple[float, Fit, Problem, str] | None = None
    state = start
    for name, more in _LADDER.items():
        terms = np.zeros(LENS, np.bool_)
        terms[[0, 1, 2, 3, *more]] = True
        lens = np.where(terms, state.lens, 0.0)
        chosen = replace(problem, terms=terms)
        fit = adjust(chosen, replace(state, lens=lens))
        state = fit.state
        score = _criterion(fit, int(terms.sum()))
        if best is None or score < best[0]:
            best = score, fit, chosen, name
    assert best is not None
    return best[1:]


def _criterion(fit: Fit, terms: int) -> float:
    """Bayesian information criterion, constants apart."""
    squares = np.vstack(fit.residuals) ** 2
    return squares.size * log(max(float(squares.mean()), 1e-12)) + terms * log(squares.size)


def mistaken(fit: Fit) -> tuple[Flags, ...]:
    """Find corners that lie where no corner can be.

    Args:
        fit: of all corners.

    Returns:
        Flags view by view, shape (N,) each.
    """
    off = [np.linalg.norm(r, axis=1) for r in fit.residuals]
    spread = float(np.median(np.concatenate(off))) / 1.1774  # of a Rayleigh distribution
    limit = max(_GROSS * spread, _GROSS_PX)
    return tuple(o > limit for o in off)


def pose_of(seen: Seen, lens: Floats) -> Floats:
    """The pose of flat points under a known lens.

    Args:
        seen: at least four points in one plane z = constant, beside their pixels.
        lens: shape (9,).

    Returns:
        Rodrigues rotation [rad] and translation [m], shape (6,): the better of the two that a
        plane allows.

    Raises:
        VisionError: if there is none.
    """
    matrix = np.array([[lens[0], 0.0, lens[2]], [0.0, lens[1], lens[3]], [0.0, 0.0, 1.0]])
    level = np.array((0.0, 0.0, seen.points[:, 2].mean()))
    try:
        _, turns, ways, _ = cv2.solvePnPGeneric(
            seen.points - level, seen.pixels, matrix, lens[4:], flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error as error:
        raise VisionError(f"the points fit no camera ({error.err})") from None
    found = []
    for turn, way in zip(turns, ways, strict=True):
        lowered = np.ravel(way) - cv2.Rodrigues(turn)[0] @ level
        start = State(lens, np.concatenate((np.ravel(turn), lowered))[None], np.zeros(6), _NOWHERE)
        if np.isfinite(start.held).all():
            found.append(adjust(Problem((seen,), None, (), _NO_LENS), start))
    if not found:
        raise VisionError("the points fit no camera")
    best: Floats = min(found, key=lambda fit: fit.rms).state.held[0]
    return best


_NOWHERE = np.zeros((0, 3))


def cross_validated(problem: Problem, fit: Fit) -> float:
    """Predict every held view with a lens that was fitted without it.

    Args:
        problem: what was fitted.
        fit: its fit.

    Returns:
        Root mean square distance of the corners from their predictions [px]; every fit is without
        every `FOLDS`-th view.
    """
    squares = []
    count = len(problem.held)
    for first in range(min(FOLDS, count)):
        out = np.arange(count) % FOLDS == first
        kept = tuple(s for s, o in zip(problem.held, out, strict=True) if not o)
        start = replace(fit.state, held=fit.state.held[~out])
        lens = adjust(replace(problem, held=kept), start).state.lens
        for index in np.flatnonzero(out).tolist():
            alone = State(lens, fit.state.held[index : index + 1], np.zeros(POSE), _NOWHERE)
            single = Problem((problem.held[index],), None, (), _NO_LENS)
            squares.append(adjust(single, alone).residuals[0] ** 2)
    return float(np.sqrt(np.vstack(squares).sum(axis=1).mean()))
