"""A camera from pictures of a board: what was fitted, how well it is known, or why it is refused."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.board import Board
from vision.calibration.bundle import LENS, Fit, Problem, State, adjust
from vision.calibration.detect import BoardView
from vision.calibration.floor import FloorFrame, camera_of, held_out_errors, with_floor
from vision.calibration.lens import (
    choose_terms,
    cross_validated,
    first_guess,
    mistaken,
    seen_on,
)
from vision.calibration.views import LEAST_VIEWS, complaints, lacking_regions
from vision.errors import VisionError

Floats = NDArray[np.float64]

LEAST_TILT_DEG = 15.0  # largest angle between two boards, at least
MOST_RMS = 1e-3  # reprojection error, of the image's width
MOST_FOCAL = 0.01  # relative standard deviation of the focal length
_ROUNDS = 3  # of leaving out mistaken corners
_ALL_TERMS = np.ones(LENS, np.bool_)
_NO_TERMS = np.zeros(LENS, np.bool_)


@dataclass(frozen=True, slots=True)
class Calibration:
    """A fitted camera.

    Attributes:
        size_px: width and height of the pictures [px].
        terms: which distortion was fitted, in words.
        problem: what was fitted: views held freely, views on the floor, terms.
        fit: lens, poses, floor, residuals and covariance.
        held: the views held freely, without mistaken corners.
        laid: the views on the floor, without mistaken corners; the first one gives the frame.
        left_out: sentences on views and corners that were left out.
        cross_px: reprojection error of views that took no part in their lens's fit [px]; NaN if the
            lens was given.
        floor_errors: shape (N,), errors of boards or points measured with a floor that was fitted
            without them [m]; empty without a floor.
    """

    size_px: tuple[int, int]
    terms: str
    problem: Problem
    fit: Fit
    held: tuple[BoardView, ...]
    laid: tuple[BoardView, ...]
    left_out: tuple[str, ...]
    cross_px: float
    floor_errors: Floats

    @property
    def has_floor(self) -> bool:
        """Whether the floor is known."""
        return self.problem.anchor is not None

    def deviations(self) -> Floats:
        """Standard deviations of fx, fy, cx, cy [px], k1, k2, p1, p2, k3, shape (9,)."""
        return np.asarray(np.sqrt(np.diag(self.fit.covariance)[:LENS]), np.float64)


def calibrate_lens(
    board: Board, views: Sequence[BoardView], laid: Sequence[BoardView], frame: FloorFrame
) -> Calibration:
    """Fit a lens to views of a board and, where there are views of it on the floor, the floor.

    Args:
        board: that was seen.
        views: boards held freely, all of one size.
        laid: the board on the floor, at one place or several; may be empty.
        frame: where the first of these lies.

    Returns:
        The camera.

    Raises:
        VisionError: if the set is too poor, with all reasons.
    """
    both = (*views, *laid)
    size_px = both[0].size_px if both else (0, 0)
    _refuse(complaints(board, both, size_px))
    _refuse_twins(board, laid)
    left_out: list[str] = []
    held, laid = tuple(views), tuple(laid)
    problem, state = _start(board, held, laid, frame, size_px)
    fit, problem, terms = choose_terms(problem, state)
    for _ in range(_ROUNDS):
        flags = mistaken(fit)
        if not any(f.any() for f in flags):
            break
        held, laid, said = _without(held, laid, flags)
        left_out += said
        _refuse(_too_few(held, laid, len(both) - len(views), left_out, fit))
        problem, state = _start(board, held, laid, frame, size_px)
        fit, problem, terms = choose_terms(problem, state)
    _refuse(_doubts(fit, problem, held, laid, size_px))
    cross, _ = cross_validated(problem, fit)
    errors = held_out_errors(size_px, problem, fit, frame.thickness) if laid else np.zeros(0)
    return Calibration(
        size_px, terms, problem, fit, held, laid, tuple(left_out), cross, errors
    )


def calibrate_floor(
    board: Board,
    lens: Floats,
    laid: Sequence[BoardView],
    frame: FloorFrame,
) -> Calibration:
    """Fit the floor alone to boards that lie on it, under a known lens.

    Args:
        board: that was seen.
        lens: shape (9,), fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        laid: the board on the floor, at least one view.
        frame: where the first one lies.

    Returns:
        The camera.

    Raises:
        VisionError: if the views do not fit the lens or each other.
    """
    _refuse_twins(board, laid)
    size_px, laid = laid[0].size_px, tuple(laid)
    alone = Problem((), None, (), _NO_TERMS)
    state = State(lens, np.zeros((0, 6)), np.zeros(6), np.zeros((0, 3)))
    fit = adjust(*with_floor(alone, state, [seen_on(board, v) for v in laid], frame))
    _, laid, said = _without((), laid, mistaken(fit))
    _refuse(_too_few((), laid, 1, said, fit, least=0))
    problem, state = with_floor(alone, state, [seen_on(board, v) for v in laid], frame)
    fit = adjust(problem, state)
    _refuse(_too_large(fit, laid, size_px))
    errors = held_out_errors(size_px, problem, fit, frame.thickness)
    return Calibration(
        size_px, "given", problem, fit, (), laid, tuple(said), float("nan"), errors
    )


def _refuse(reasons: Sequence[str]) -> None:
    if reasons:
        raise VisionError("; ".join(reasons))


def _refuse_twins(board: Board, laid: Sequence[BoardView]) -> None:
    """A board that looks the same upside down gives no floor frame."""
    if laid and board.upside_down_twin:
        raise VisionError(
            f"a chessboard of {board.columns} x {board.rows} squares looks the same upside down: "
            "for the floor use one whose columns and rows are not both even or both odd, or markers"
        )


def _start(
    board: Board,
    held: tuple[BoardView, ...],
    laid: tuple[BoardView, ...],
    frame: FloorFrame,
    size_px: tuple[int, int],
) -> tuple[Problem, State]:
    """The problem of all views, and a first guess."""
    free, flat = [seen_on(board, v) for v in held], [seen_on(board, v) for v in laid]
    state = first_guess([*free, *flat], size_px)
    state = replace(state, held=state.held[: len(free)])
    problem = Problem(tuple(free), None, (), _ALL_TERMS)
    if not flat:
        return problem, state
    alone = adjust(replace(problem, terms=_EARLY), state).state if free else state
    return with_floor(problem, alone, flat, frame)


_EARLY = np.array([True] * 4 + [True] + [False] * 4)  # k1 alone is safe before anything is known


def _without(
    held: tuple[BoardView, ...], laid: tuple[BoardView, ...], flags: Sequence[NDArray[np.bool_]]
) -> tuple[tuple[BoardView, ...], tuple[BoardView, ...], list[str]]:
    """Views without mistaken corners, and without views in which a third are mistaken."""
    said, kept = [], []
    for view, wrong in zip((*held, *laid), flags, strict=True):
        small = len(wrong) - wrong.sum() < 6
        if 3 * wrong.sum() > len(wrong) or small:
            said.append(f"{view.name}: left out, {wrong.sum()} of {len(wrong)} corners do not fit")
            kept.append(None)
            continue
        if wrong.any():
            said.append(f"{view.name}: {wrong.sum()} of {len(wrong)} corners left out")
        kept.append(view.at(~wrong))
    free, flat = kept[: len(held)], kept[len(held) :]
    return tuple(v for v in free if v), tuple(v for v in flat if v), said


def _too_few(
    held: Sequence[BoardView],
    laid: Sequence[BoardView],
    on_floor: int,
    said: Sequence[str],
    fit: Fit,
    least: int = LEAST_VIEWS,
) -> list[str]:
    """Complaints when views that do not fit leave too few."""
    if len(held) + len(laid) >= least and (laid or not on_floor):
        return []
    what = "no view of the floor" if on_floor and not laid else f"{len(held) + len(laid)} views"
    return [
        f"the views do not fit one flat board and one camera (reprojection error {fit.rms:.2f} px); "
        f"without the worst, {what} would be left: {'; '.join(said)}"
    ]


def _doubts(
    fit: Fit,
    problem: Problem,
    held: Sequence[BoardView],
    laid: Sequence[BoardView],
    size_px: tuple[int, int],
) -> list[str]:
    """Why a fit is not to be trusted."""
    found = _too_large(fit, (*held, *laid), size_px)
    tilt = np.degrees(largest_tilt(problem, fit.state))
    if tilt < LEAST_TILT_DEG:
        found.append(
            f"all boards are nearly parallel (at most {tilt:.0f} deg apart, "
            f"{LEAST_TILT_DEG:.0f} needed): tilt the board differently in every picture"
        )
    spread = np.sqrt(np.diag(fit.covariance)[:2]) / fit.state.lens[:2]
    if not spread.max() < MOST_FOCAL:
        found.append(
            f"the focal length is known to {100 * spread.max():.1f} % only "
            f"({100 * MOST_FOCAL:.0f} % needed): tilt the board more, and show it closer"
        )
    if not found and not _sees_everywhere(fit.state.lens, size_px):
        lacking = ", ".join(lacking_regions((*held, *laid), size_px)) or "the outermost corners"
        found.append(f"the lens model fails towards the border: show the board at {lacking}")
    return found


def _too_large(fit: Fit, views: Sequence[BoardView], size_px: tuple[int, int]) -> list[str]:
    """Complaints about the reprojection error, the worst views named."""
    limit = MOST_RMS * size_px[0]
    if fit.rms <= limit:
        return []
    each = [float(np.sqrt((r**2).sum(axis=1).mean())) for r in fit.residuals]
    worst = sorted(zip(each, (v.name for v in views), strict=True), reverse=True)[:3]
    named = ", ".join(f"{name} {error:.2f} px" for error, name in worst)
    return [
        f"reprojection error {fit.rms:.2f} px ({limit:.2f} px allowed), worst: {named}: is the "
        "board flat and the picture still?"
    ]


def largest_tilt(problem: Problem, state: State) -> float:
    """The largest angle between the faces of two boards.

    Args:
        problem: what was fitted.
        state: its poses.

    Returns:
        The angle [rad].
    """
    poses = [*state.held, *([state.floor] if problem.anchor is not None else [])]
    normals = np.array([cv2.Rodrigues(pose[:3])[0][:, 2] for pose in poses])
    return float(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)))


def _sees_everywhere(lens: Floats, size_px: tuple[int, int]) -> bool:
    """Whether the lens model can be inverted all along the image's border."""
    ahead = camera_of(size_px, lens, np.array((np.pi, 0.0, 0.0, 0.0, 0.0, 1.0)), 0.0)
    w, h = size_px[0] - 0.5, size_px[1] - 0.5
    border = [(x, y) for x in np.linspace(-0.5, w, 9) for y in (-0.5, h)]
    border += [(x, y) for y in np.linspace(-0.5, h, 9) for x in (-0.5, w)]
    floor = ahead.to_floor(np.array(border), 0.0)
    again = ahead.project(np.column_stack((floor, np.zeros(len(floor)))))
    return bool((np.abs(again - border) < 1e-3).all() and _grows(lens, size_px))


def _grows(lens: Floats, size_px: tuple[int, int]) -> bool:
    """Whether the picture's radius grows with the ray's, out to the image's corners."""
    reach = np.hypot(*(np.array(size_px) / lens[:2])) * 0.55
    r = np.linspace(0.0, reach, 60)
    k1, k2, k3 = lens[4], lens[5], lens[8]
    distorted = r * (1.0 + r**2 * (k1 + r**2 * (k2 + r**2 * k3)))
    inside = distorted < np.hypot(*(np.array(size_px) / lens[:2])) * 0.5
    return bool((np.diff(distorted)[inside[1:]] > 0.0).all())
