"""Calibration boards: OpenCV's own, those that cannot be, and pictures without one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.vision.filmed_boards import BOARD, CHECKERS, film, flat_pose, tilted
from vision.calibration.board import Board
from vision.calibration.detect import find_board
from vision.errors import VisionError


@pytest.mark.parametrize(
    "board",
    [
        Board("charuco", 8, 5, 0.04, 0.03),
        Board("charuco", 6, 4, 0.04, 0.03, "5x5_100"),
        Board("charuco", 6, 4, 0.04, 0.03, "5x5_100", legacy=True),
    ],
)
def test_boards_are_those_of_opencv(board: Board) -> None:
    k = 84  # pixels per square; markers of 63 px have whole cells
    size = (board.columns * k, board.rows * k)
    wanted = board.opencv_board().generateImage(size, marginSize=0)
    drawn = np.full(wanted.shape, 255, np.uint8)
    for cell in board.black_cells():
        low, high = np.rint(cell[0] / board.square * k), np.rint(cell[2] / board.square * k)
        rows = slice(int(size[1] - high[1]), int(size[1] - low[1]))
        drawn[rows, int(low[0]) : int(high[0])] = 0
    differing = np.abs(drawn.astype(int) - wanted) > 128
    assert differing.mean() < 0.02  # OpenCV rounds the cells of its markers


def test_impossible_boards_are_refused() -> None:
    for wrong, said in (
        ({"columns": 2}, "need 3 to 60"),
        ({"columns": 3, "rows": 3}, "fewer than 6 inner corners"),
        ({"square": 0.0}, "a square of 0 mm"),
        ({"marker": 0.05}, "do not fit"),
        ({"dictionary": "4x4"}, "no dictionary"),
        ({"columns": 20, "rows": 11}, "needs 110 markers, dictionary 4x4_100 has 100"),
    ):
        with pytest.raises(VisionError, match=said):
            replace(BOARD, **wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", [(1, 1), (3, 500), (9, 9), (40, 40)])
def test_tiny_pictures_hold_no_board(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(0).integers(0, 256, (*shape, 3)).astype(np.uint8)
    for board in (BOARD, CHECKERS):
        assert isinstance(find_board(picture, board), str)


def test_pictures_without_the_board_say_what_is_there() -> None:
    picture = film(tilted()).picture(*flat_pose(0.1, 0.1, 0.3))
    other = replace(BOARD, dictionary="6x6_250")
    assert "no marker of dictionary 6x6_250" in str(find_board(picture, other))
    assert "no chessboard of 9 x 6" in str(find_board(picture, CHECKERS))
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3)).astype(np.uint8)
    for board in (BOARD, CHECKERS):
        assert isinstance(find_board(noise, board), str)
