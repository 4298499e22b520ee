"""Tags: geometry, nesting, and refusal of what cannot be told apart."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import datasets
from tests.vision.worlds import TRIANGLE, TWO_PATCH, rectangle, two_patch_tags
from vision.errors import VisionError
from vision.tags import Layout, Part, Tag, TagSet, polygon_array

PLATE = Part("plate", rectangle(-37.5, 37.5, -37.5, 37.5), "black")


def worn(robot_id: int, rear: str) -> Tag:
    return TWO_PATCH.worn_by(robot_id, (("$rear", rear),))


def test_areas_and_centroids_of_what_is_visible() -> None:
    hole = Part("hole", rectangle(10, 30, -10, 10), "red")
    dot = Part("dot", rectangle(15, 20, -2, 2), "black")
    tag = Tag(1, (PLATE, hole, dot))
    assert tag.parents == (-1, 0, 1)
    assert tag.children(0) == (1,)
    assert tag.visible_area(0) == pytest.approx((75**2 - 400) * 1e-6)
    assert tag.visible_area(1) == pytest.approx((400 - 20) * 1e-6)
    # centre of the plate without the hole: 75^2 * 0 = (75^2 - 400) x + 400 * 20
    np.testing.assert_allclose(tag.visible_centroid(0), [-8.0 / (75**2 - 400), 0.0], atol=1e-12)


def test_radii_of_the_square_plate() -> None:
    tag = worn(1, "red")
    assert tag.outer_radius == pytest.approx(0.0375 * 2**0.5)
    assert tag.inner_radius == pytest.approx(0.0375)
    assert tag.side == pytest.approx(0.075)


def test_orientation_of_the_polygon_does_not_matter() -> None:
    part = worn(1, "red").parts[1]
    turned = Part(part.name, polygon_array(part.polygon[::-1]), part.color)
    assert turned.area == pytest.approx(part.area)
    np.testing.assert_allclose(turned.centroid, part.centroid)


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (Part("hole", rectangle(20, 50, -10, 10), "red"), "58% of part hole covers part plate"),
        (Part("cover", rectangle(-40, 40, -40, 40), "red"), "of part cover covers part plate"),
        (Part("twin", PLATE.polygon, "red"), "part twin hides part plate"),
    ],
)
def test_parts_that_overlap_partly_are_refused(extra: Part, message: str) -> None:
    with pytest.raises(VisionError, match=message):
        Tag(7, (PLATE, extra))


def test_tags_without_colour_are_refused() -> None:
    with pytest.raises(VisionError, match=r"robot 4.*another colour than black"):
        TagSet((Tag(4, (PLATE,)),))


@pytest.mark.parametrize(
    ("one", "other", "message"),
    [
        ((1, "red"), (2, "red"), "robots 1 and 2 wear the same tag.*look_alikes"),
        ((1, "red"), (1, "blue"), "robot 1 has 2 tags"),
    ],
)
def test_twins_are_refused(one: tuple[int, str], other: tuple[int, str], message: str) -> None:
    with pytest.raises(VisionError, match=message):
        TagSet((worn(*one), worn(*other)))


def test_a_turned_twin_is_refused() -> None:
    swapped = Layout("swapped", tuple(_swapped(part) for part in TWO_PATCH.parts))
    with pytest.raises(VisionError, match=r"robots 1 and 2 .*turned by 180 deg"):
        TagSet((worn(1, "red"), swapped.worn_by(2, (("$rear", "red"),))))


def _swapped(part: Part) -> Part:
    return Part(part.name, polygon_array(-part.polygon), part.color)


def test_a_tag_without_a_heading_is_refused() -> None:
    with pytest.raises(VisionError, match="robot 1 looks the same when turned by 180 deg"):
        TagSet((worn(1, "yellow"),))


def test_mirror_twins_need_consent() -> None:
    one = TRIANGLE.worn_by(0, (("$left", "green"), ("$back", "violet")))
    other = TRIANGLE.worn_by(2, (("$left", "violet"), ("$back", "green")))
    with pytest.raises(VisionError, match=r"robots 0 and 2 .*mirrored"):
        TagSet((one, other))
    assert TagSet((one, other), mirror_twins=True).ids == (0, 2)


def test_seven_robots_of_the_default_layout_are_told_apart() -> None:
    tags = two_patch_tags(7)
    assert tags.ids == tuple(range(1, 8))
    assert tags.search_colors[:2] == ("yellow", "red")


def test_placeholders_need_their_colour() -> None:
    with pytest.raises(VisionError, match=r"two_patch, robot 3: needs colours for \['\$rear'\]"):
        TWO_PATCH.worn_by(3, ())


def test_the_layout_file_is_the_layout_tested_here() -> None:
    path = Path(datasets.__file__).parent / "layouts" / "two_patch.toml"
    data = tomllib.loads(path.read_text())
    assert data["side_m"] == 0.075
    for part, tested in zip(data["parts"], TWO_PATCH.parts, strict=True):
        assert (part["name"], part["color"]) == (tested.name, tested.color)
        polygon = polygon_array(part["polygon_m"])
        np.testing.assert_allclose(polygon, tested.polygon, atol=1e-12)


@pytest.mark.parametrize("points", [[[0, 0], [1, 1]], [[0, 0], [1, 1], [2, 2]], [[0, 0, 0]] * 3])
def test_polygons_without_area_are_refused(points: list[list[float]]) -> None:
    with pytest.raises(VisionError, match="polygon"):
        polygon_array(points)
