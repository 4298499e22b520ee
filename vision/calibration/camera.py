"""A camera from pictures of a board: what was fitted, how well it is known, or the refusal."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.calibration.board import Board
from vision.calibration.bundle import LENS, Fit, Problem, State, adjust
from vision.calibration.detect import BoardView
from vision.calibration.doubts import lens_doubts, too_few, too_large
from vision.calibration.floor import (
    FittedFloor,
    FloorFrame,
    held_out_errors,
    with_floor,
)
from vision.calibration.lens import (
    choose_terms,
    cross_validated,
    first_guess,
    mistaken,
    seen_on,
)
from vision.calibration.points import KnownPoint, floor_of_points
from vision.calibration.result import GIVEN, Calibration
from vision.calibration.views import complaints
from vision.errors import VisionError

Floats = NDArray[np.float64]

_EXACT = np.zeros((LENS, LENS))
_LEAST_CORNERS = 6
_ROUNDS = 3  # of leaving out mistaken corners
_ALL_TERMS = np.ones(LENS, np.bool_)
_NO_TERMS = np.zeros(LENS, np.bool_)


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
    _refuse(complaints(both, size_px))
    _refuse_twins(board, laid)
    used = _Views(tuple(views), tuple(laid), ())
    problem, fit, terms, used = _robust(board, used, frame, size_px)
    _refuse(lens_doubts(fit, problem, (*used.held, *used.laid), size_px))
    return Calibration(
        size_px=size_px,
        lens=fit.state.lens,
        covariance=fit.covariance[:LENS, :LENS],
        terms=terms,
        views=(*used.held, *used.laid),
        residuals=fit.residuals,
        left_out=used.left_out,
        cross_px=cross_validated(problem, fit),
        floor=_floor(problem, fit, frame, size_px) if laid else None,
    )


@dataclass(frozen=True, slots=True)
class _Views:
    """Views in the hands, on the floor, and sentences on what was left out."""

    held: tuple[BoardView, ...]
    laid: tuple[BoardView, ...]
    left_out: tuple[str, ...]


def _robust(
    board: Board, views: _Views, frame: FloorFrame, size_px: tuple[int, int]
) -> tuple[Problem, Fit, str, _Views]:
    """Fit, leave out mistaken corners, fit again."""
    for remaining in range(_ROUNDS, -1, -1):
        problem, state = _start(board, views.held, views.laid, frame, size_px)
        fit, problem, terms = choose_terms(problem, state)
        flags = mistaken(fit)
        if not remaining or not any(f.any() for f in flags):
            break
        less = _without(views, flags)
        _refuse(too_few(views.laid, less.held, less.laid, less.left_out, fit))
        views = less
    return problem, fit, terms, views


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
    size_px, views = laid[0].size_px, _Views((), tuple(laid), ())
    fit = adjust(*_floor_problem(board, lens, views.laid, frame))
    less = _without(views, mistaken(fit))
    _refuse(too_few(laid, (), less.laid, less.left_out, fit, least=1))
    problem, state = _floor_problem(board, lens, less.laid, frame)
    fit = adjust(problem, state)
    _refuse(too_large(fit, less.laid, size_px))
    return Calibration(
        size_px=size_px,
        lens=lens,
        covariance=_EXACT,
        terms=GIVEN,
        views=less.laid,
        residuals=fit.residuals,
        left_out=less.left_out,
        cross_px=float("nan"),
        floor=_floor(problem, fit, frame, size_px),
    )


def _floor_problem(
    board: Board, lens: Floats, laid: Sequence[BoardView], frame: FloorFrame
) -> tuple[Problem, State]:
    """Boards on the floor under a known lens, and a first guess."""
    alone = Problem((), None, (), _NO_TERMS)
    state = State(lens, np.zeros((0, 6)), np.zeros(6), np.zeros((0, 3)))
    return with_floor(alone, state, [seen_on(board, view) for view in laid], frame)


def with_points(lens: Calibration, points: Sequence[KnownPoint]) -> Calibration:
    """Add the floor from points at known places.

    Args:
        lens: calibrated.
        points: on the floor, or tags of known places and heights.

    Returns:
        The calibration with a floor.

    Raises:
        VisionError: if the points are refused; see `floor_of_points`.
    """
    fit, errors = floor_of_points(points, lens.lens, lens.covariance, lens.size_px)
    floor = FittedFloor(fit.state.floor, fit.covariance, errors, fit.rms, 0)
    return replace(lens, floor=floor)


def _floor(problem: Problem, fit: Fit, frame: FloorFrame, size_px: tuple[int, int]) -> FittedFloor:
    """The floor of a fit, checked."""
    errors = held_out_errors(size_px, problem, fit, frame.thickness)
    squares = np.vstack(fit.residuals[len(problem.held) :]) ** 2
    rms = float(np.sqrt(squares.sum(axis=1).mean()))
    return FittedFloor(
        fit.state.floor, fit.covariance, errors, rms, len(fit.residuals) - len(problem.held)
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


def _without(views: _Views, flags: Sequence[NDArray[np.bool_]]) -> _Views:
    """Views without mistaken corners, and without views in which a third are mistaken."""
    said = list(views.left_out)
    kept: list[BoardView | None] = []
    for view, wrong in zip((*views.held, *views.laid), flags, strict=True):
        count = int(wrong.sum())
        if 3 * count > len(wrong) or len(wrong) - count < _LEAST_CORNERS:
            said.append(f"{view.name}: left out, {count} of {len(wrong)} corners do not fit")
            kept.append(None)
            continue
        if count:
            said.append(f"{view.name}: {count} of {len(wrong)} corners left out")
        kept.append(view.at(~wrong))
    held, laid = kept[: len(views.held)], kept[len(views.held) :]
    return _Views(tuple(v for v in held if v), tuple(v for v in laid if v), tuple(said))
