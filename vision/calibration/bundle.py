"""Lens, board poses and floor plane fitted at once to all corners: a bundle adjustment.

Parameters: the lens (fx, fy, cx, cy, k1, k2, p1, p2, k3), six numbers (Rodrigues rotation, then
translation) for every board held freely and for the floor, and (x, y, turn) for every board that
lies somewhere on the floor. Damped Gauss-Newton steps (Levenberg-Marquardt) on the pixels'
residuals, with exact derivatives; free poses are eliminated view by view. The covariance is the
inverse normal matrix times the variance of the residuals.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LENS = 9  # fx, fy, cx, cy, k1, k2, p1, p2, k3
POSE = 6
PLACE = 3
_STEPS = 60
_DAMPING = 1e-4
_DONE = 1e-9  # relative gain of a step that ends the fit
_STUCK = 1e8  # damping at which no step helps any more


@dataclass(frozen=True, slots=True)
class Seen:
    """Known points and the pixels at which one picture shows them.

    Attributes:
        points: shape (N, 3), on the board, or in the floor frame [m].
        pixels: shape (N, 2) [px].
    """

    points: Floats
    pixels: Floats


@dataclass(frozen=True, slots=True)
class Problem:
    """What is fitted.

    Attributes:
        held: boards held freely, each with a pose of its own.
        anchor: points given in the floor frame, None if there is no floor.
        laid: boards that lie on the floor at unknown places.
        terms: shape (9,), which numbers of the lens are fitted; the others keep their values.
    """

    held: tuple[Seen, ...]
    anchor: Seen | None
    laid: tuple[Seen, ...]
    terms: Flags


@dataclass(frozen=True, slots=True)
class State:
    """All unknowns.

    Attributes:
        lens: shape (9,), fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        held: shape (F, 6), R_camera_board as Rodrigues vector [rad] and t_camera_board [m].
        floor: shape (6,), the same of the floor; zeros if there is none.
        laid: shape (L, 3), x, y, turn of the boards on the floor [m, m, rad].
    """

    lens: Floats
    held: Floats
    floor: Floats
    laid: Floats


@dataclass(frozen=True, slots=True)
class Fit:
    """The outcome.

    Attributes:
        state: the unknowns at the minimum.
        residuals: of held, anchor and laid, in this order: found minus predicted, (N, 2) each [px].
        covariance: shape (15, 15), of lens and floor, zero where nothing was fitted.
    """

    state: State
    residuals: tuple[Floats, ...]
    covariance: Floats

    @property
    def rms(self) -> float:
        """Root mean square distance of corners from their predictions [px]."""
        joined = np.vstack(self.residuals)
        return float(np.sqrt((joined**2).sum(axis=1).mean()))


def adjust(problem: Problem, start: State) -> Fit:
    """Fit.

    Args:
        problem: what was seen, and what is free.
        start: first guess.

    Returns:
        The fit.
    """
    state, damping = start, _DAMPING
    rows = _linear(problem, state)
    for _ in range(_STEPS):
        tried = _moved(problem, state, *_step(problem, rows, damping))
        after = _linear(problem, tried)
        before = _squares(rows)
        gain = before - _squares(after)
        if not gain > 0.0:
            damping *= 10.0
            if damping > _STUCK:
                break
            continue
        state, rows, damping = tried, after, damping * 0.2
        if gain < _DONE * before:
            break
    return Fit(state, tuple(r.residual.reshape(-1, 2) for r in rows), _covariance(problem, rows))


@dataclass(frozen=True, slots=True)
class _Rows:
    """One view's part of the linear system.

    Attributes:
        columns: which of the shared unknowns it depends on: lens, floor, places on the floor.
        shared: derivatives by these, shape (2 N, K).
        own: derivatives by the pose of a board held freely, shape (2 N, 6) or (2 N, 0).
        residual: shape (2 N,).
    """

    columns: NDArray[np.intp]
    shared: Floats
    own: Floats
    residual: Floats


def _views(problem: Problem) -> tuple[Seen, ...]:
    anchor = (problem.anchor,) if problem.anchor is not None else ()
    return (*problem.held, *anchor, *problem.laid)


def _shared_size(problem: Problem) -> int:
    floor = POSE if problem.anchor is not None else 0
    return LENS + floor + PLACE * len(problem.laid)


def _linear(problem: Problem, state: State) -> list[_Rows]:
    """The linear system, view by view."""
    lens_columns, rows = np.arange(LENS), []
    for index, seen in enumerate(_views(problem)):
        number = index - len(problem.held) - 1  # of a board after the anchor
        if number < -1:
            predicted, lens, own = projected(seen.points, state.held[index], state.lens)
            columns, shared = lens_columns, lens * problem.terms
        else:
            predicted, lens, floor = _floor_view(seen.points, state, number)
            places = np.arange(PLACE if number >= 0 else 0) + LENS + POSE + PLACE * number
            columns = np.concatenate((np.arange(LENS + POSE), places))
            shared, own = np.hstack((lens * problem.terms, floor)), floor[:, :0]
        rows.append(_Rows(columns, shared, own, seen.pixels.reshape(-1) - predicted))
    return rows


def _floor_view(points: Floats, state: State, number: int) -> tuple[Floats, Floats, Floats]:
    """The anchor (-1) or a board somewhere on the floor: derivatives by floor and place."""
    place = state.laid[number] if number >= 0 else np.zeros(PLACE)
    on_floor = placed(points, place)
    predicted, lens, pose = projected(on_floor, state.floor, state.lens)
    if number < 0:
        return predicted, lens, pose
    axes = cv2.Rodrigues(state.floor[:3])[0]
    by_floor = (pose[:, 3:] @ axes).reshape(-1, 2, 3)  # d pixel / d point of the floor frame
    turning = np.column_stack((place[1] - on_floor[:, 1], on_floor[:, 0] - place[0]))
    by_turn = np.einsum("nij,nj->ni", by_floor[:, :, :2], turning)
    shift = np.concatenate((by_floor[:, :, :2], by_turn[:, :, None]), axis=2).reshape(-1, PLACE)
    return predicted, lens, np.hstack((pose, shift))


def _step(problem: Problem, rows: list[_Rows], damping: float) -> tuple[Floats, Floats]:
    """One damped step of the shared unknowns (K,) and of the free poses (F, 6)."""
    normal, right, eliminated = _reduced(problem, rows, damping)
    diagonal = np.diag(normal)
    there = diagonal > 0.0  # directions that nothing determines stay where they are
    scale = np.sqrt(np.where(there, diagonal, 1.0))
    scaled = normal / np.outer(scale, scale) + np.diag(np.where(there, 1e-13, 1.0))
    shared = np.linalg.solve(scaled, right / scale) / scale
    poses = [free - by_lens @ shared[:LENS] for free, by_lens in eliminated]
    return shared, np.reshape(poses, (-1, POSE))


def _reduced(
    problem: Problem, rows: list[_Rows], damping: float
) -> tuple[Floats, Floats, list[tuple[Floats, Floats]]]:
    """Normal matrix (K, K) and right side (K,) of the shared unknowns, free poses eliminated.

    Also, for every free pose, its step (6,) at a fixed lens and how the lens changes it (6, 9).
    """
    size = _shared_size(problem)
    normal, right = np.zeros((size, size)), np.zeros(size)
    eliminated: list[tuple[Floats, Floats]] = []
    for row in rows:
        block, part = row.shared.T @ row.shared, row.shared.T @ row.residual
        block += np.diag(damping * np.diag(block))
        if row.own.shape[1]:
            pose = row.own.T @ row.own
            pose += np.diag(damping * np.diag(pose) + 1e-12 * np.trace(pose))
            cross = row.own.T @ row.shared
            sides = np.column_stack((row.own.T @ row.residual, cross))
            solved = np.asarray(np.linalg.solve(pose, sides), np.float64)
            free, by_lens = solved[:, 0], solved[:, 1:]
            eliminated.append((free, by_lens))
            block, part = block - cross.T @ by_lens, part - cross.T @ free
        normal[np.ix_(row.columns, row.columns)] += block
        right[row.columns] += part
    return normal, right, eliminated


def _squares(rows: list[_Rows]) -> float:
    return float(sum(row.residual @ row.residual for row in rows))


def projected(points: Floats, pose: Floats, lens: Floats) -> tuple[Floats, Floats, Floats]:
    """Predict pixels and their derivatives.

    Args:
        points: shape (N, 3) [m].
        pose: shape (6,), Rodrigues rotation [rad] and translation [m].
        lens: shape (9,).

    Returns:
        Pixels x0, y0, x1, ... (2 N,); derivatives by the lens (2 N, 9) and the pose (2 N, 6).
    """
    matrix = np.array([[lens[0], 0.0, lens[2]], [0.0, lens[1], lens[3]], [0.0, 0.0, 1.0]])
    points = np.ascontiguousarray(points)  # OpenCV takes no strides
    pixels, slope = cv2.projectPoints(points, pose[:3], pose[3:], matrix, lens[4:])
    slope = np.asarray(slope, np.float64)[:, : POSE + LENS]
    return np.asarray(pixels, np.float64).reshape(-1), slope[:, POSE:], slope[:, :POSE]


def placed(points: Floats, place: Floats) -> Floats:
    """Move a board on the floor.

    Args:
        points: shape (N, 3), in the board's frame [m].
        place: shape (3,), x, y, turn [m, m, rad].

    Returns:
        Shape (N, 3), in the floor frame [m].
    """
    c, s = np.cos(place[2]), np.sin(place[2])
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved: Floats = points @ turn.T + (place[0], place[1], 0.0)
    return moved


def _moved(problem: Problem, state: State, shared: Floats, poses: Floats) -> State:
    """The state one step further."""
    floor = POSE if problem.anchor is not None else 0
    lens, plane, places = np.split(shared, np.cumsum((LENS, floor)))
    return replace(
        state,
        lens=state.lens + lens * problem.terms,
        held=state.held + poses,
        floor=state.floor + plane if floor else state.floor,
        laid=state.laid + places.reshape(-1, PLACE),
    )


def _covariance(problem: Problem, rows: list[_Rows]) -> Floats:
    """Covariance of lens and floor, shape (15, 15)."""
    normal, _, eliminated = _reduced(problem, rows, 0.0)
    used = np.flatnonzero(np.diag(normal) > 0.0)
    unknowns = len(used) + POSE * len(eliminated)
    freedom = max(sum(len(row.residual) for row in rows) - unknowns, 1)
    scale = np.sqrt(np.diag(normal)[used])
    scaled = normal[np.ix_(used, used)] / np.outer(scale, scale)
    inverse = np.linalg.pinv(scaled, rcond=1e-15, hermitian=True) / np.outer(scale, scale)
    whole = np.zeros_like(normal)
    whole[np.ix_(used, used)] = inverse * (_squares(rows) / freedom)
    covariance = np.zeros((LENS + POSE, LENS + POSE))
    count = min(len(whole), LENS + POSE)
    covariance[:count, :count] = whole[:count, :count]
    return covariance
