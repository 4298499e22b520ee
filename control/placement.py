"""Where a follower should stand: the place on the floor that its references name."""

from collections.abc import Sequence
from math import cos, hypot, sin, sqrt

from control.formation import ShapeReference
from control.geometry import Pose2D
from control.relative import Vector2


def wanted_pose(
    leaders: Sequence[Pose2D],
    references: Sequence[ShapeReference],
    follower: Pose2D,
    camera_offset: float,
) -> Pose2D:
    """Where a follower should be, with the heading that it has.

    Args:
        leaders: the poses of its leaders, one or two [m, m, rad].
        references: to each of them.
        follower: its present pose; of the two places about two leaders the nearer one counts.
        camera_offset: d [m].

    Returns:
        The pose that puts its camera point where (6) and (7) want it; between two leaders whose
        circles do not meet the place nearest to both.
    """
    ahead = camera_offset * cos(follower.theta), camera_offset * sin(follower.theta)
    if len(leaders) == 1:
        x, y = _about(leaders[0], references[0])
    else:
        near = follower.x + ahead[0], follower.y + ahead[1]
        x, y = _between(leaders, references, near)
    return Pose2D(x - ahead[0], y - ahead[1], follower.theta)


def _about(leader: Pose2D, reference: ShapeReference) -> Vector2:
    angle = leader.theta + reference.bearing
    return (
        leader.x + reference.distance * cos(angle),
        leader.y + reference.distance * sin(angle),
    )


def _between(
    leaders: Sequence[Pose2D], references: Sequence[ShapeReference], near: Vector2
) -> Vector2:
    """Where the circles about two leaders meet, on the side of a point."""
    (one, two), (r1, r2) = leaders, (reference.distance for reference in references)
    x, y = two.x - one.x, two.y - one.y
    apart = hypot(x, y)
    if apart == 0.0:
        return near
    along = 0.5 * (apart + (r1 * r1 - r2 * r2) / apart)
    aside = sqrt(max(r1 * r1 - along * along, 0.0))
    left = x * (near[1] - one.y) - y * (near[0] - one.x) >= 0.0
    aside = aside if left else -aside
    return one.x + (along * x - aside * y) / apart, one.y + (along * y + aside * x) / apart
