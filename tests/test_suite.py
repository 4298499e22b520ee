"""All parts of the tests must pass."""

import pytest

from tests.__main__ import judged


@pytest.mark.parametrize(
    ("statuses", "status"),
    [
        ([0, 0, 0], 0),
        ([5, 5, 0], 0),
        ([0, 0, 1], 1),
        ([0, 1], 1),
        ([1, 0], 1),
        ([0, 5], 0),
        ([5, 0], 0),
        ([5, 5], 5),
        ([5, 2], 2),
    ],
)
def test_a_failed_part_fails_and_an_empty_one_does_not(statuses: list[int], status: int) -> None:
    assert judged(statuses) == status
