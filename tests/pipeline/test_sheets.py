"""Printed sheets: rasterised and measured, and their tags found again in the raster."""

from math import hypot
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
import pytest
from numpy.typing import NDArray

from pipeline.cli.tagging import make_sheet, tags_scenario
from pipeline.errors import ConfigError
from pipeline.seeing import make_seeing
from pipeline.sheets.arrange import PAPERS, paper_named, tag_box
from pipeline.sheets.pdf import Sheet, ruler_start, sheet_pdf
from tests.pipeline.commands import echelon
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT

Image = NDArray[np.uint8]
FINE = 16  # pixels per millimetre where lengths are measured


def raster(pdf: pypdfium2.PdfDocument, page: int, px_per_mm: float) -> Image:
    """A page as a printer would put it on paper, shape (H, W, 3), BGR."""
    return np.asarray(pdf[page].render(scale=px_per_mm * 25.4 / 72.0).to_numpy()[..., :3])


def printed(sheet: Sheet) -> pypdfium2.PdfDocument:
    return pypdfium2.PdfDocument(sheet_pdf(sheet))


def dark_run(line: NDArray[np.float64], around: float) -> tuple[float, float]:
    """Where the dark run around a place begins and ends, to a fraction of a pixel [mm]."""
    dark = line < 128.0
    first = last = round(around * FINE)
    assert dark[first]
    while dark[first - 1]:
        first -= 1
    while dark[last + 1]:
        last += 1
    before, after = (line[first - 1], line[first]), (line[last], line[last + 1])
    begins = first - 1 + (before[0] - 128.0) / (before[0] - before[1])
    ends = last + (128.0 - after[0]) / (after[1] - after[0])
    return (begins + 0.5) / FINE, (ends + 0.5) / FINE


@pytest.mark.parametrize("paper", ["a4", "letter"])
def test_tags_and_ruler_have_their_true_size(paper: str) -> None:
    sheet = make_sheet(tags_scenario("two_patch"), paper)
    size = sheet.paper
    gray = raster(printed(sheet), 0, FINE).astype(np.float64).mean(axis=2)
    assert gray.shape[1] / FINE == pytest.approx(size.width, abs=0.05)
    for placed in sheet.pages[0]:
        rim = 36.0  # in the black rim behind the coloured patches, where the rim is unbroken
        row = gray[round((size.height - placed.y + rim) * FINE)]
        left, right = dark_run(row, placed.x)
        column = gray[:, round((placed.x + rim) * FINE)]
        top, bottom = dark_run(column, size.height - placed.y)
        assert right - left == pytest.approx(75.0, abs=0.07)
        assert bottom - top == pytest.approx(75.0, abs=0.07)
        assert 0.5 * (left + right) == pytest.approx(placed.x, abs=0.1)
        assert 0.5 * (top + bottom) == pytest.approx(size.height - placed.y, abs=0.1)
    x, y = ruler_start(size)
    row = gray[round((size.height - y - 3.0) * FINE)]
    marks = [np.mean(dark_run(row, x + mm)) for mm in range(0, 101, 10)]
    np.testing.assert_allclose(np.diff(marks), 10.0, atol=0.05)
    assert marks[-1] - marks[0] == pytest.approx(100.0, abs=0.1)


@pytest.mark.parametrize("layout", ["two_patch", "triangle", "quarters", "vsss", "vsss_corner"])
def test_printed_tags_are_found_on_the_sheet(layout: str) -> None:
    sheet = make_sheet(tags_scenario(layout), "a4")
    check_found(sheet, layout, 0.7)


def test_the_leagues_robots_are_found_on_their_sheets() -> None:
    sheet = make_sheet(tags_scenario("ssl_butterfly", ("tags.colors.team=blue",)), "letter")
    assert len(sheet.pages) == 16
    check_found(sheet, "ssl_butterfly", 0.5, ("tags.colors.team=blue",), pages=(0, 15))


def test_printed_markers_are_found_on_the_sheet() -> None:
    check_found(make_sheet(tags_scenario("aruco"), "a4"), "aruco", 2.0)


def check_found(
    sheet: Sheet,
    what: str,
    px_per_mm: float,
    changes: tuple[str, ...] = (),
    pages: tuple[int, ...] = (0,),
) -> None:
    """Take a picture of pages and locate the tags in it, with the paper as the floor."""
    width, height = sheet.paper.width, sheet.paper.height
    columns, rows = round(width * px_per_mm), round(height * px_per_mm)
    view = (
        f"camera.width_px={columns}", f"camera.height_px={rows}", "camera.tag_height_m=0.0",
        f"camera.field_width_m={width / 1e3}", f"camera.center_m=[{width / 2e3}, {height / 2e3}]",
        "sensor.blur_px=0.6", "sensor.read_noise=1.0", 'sensor.chroma="444"',
    )  # fmt: skip
    seeing, pdf = make_seeing(tags_scenario(what, (*view, *changes))), printed(sheet)
    for page in pages:
        image = shrunk(raster(pdf, page, 6 * px_per_mm), (rows, columns))
        seen = seeing.detector.locate(as_frame(image, 0.0, 0), (), PALETTE_LIGHT).detections
        placed = {p.printed.tag.robot_id: p for p in sheet.pages[page]}
        assert {d.robot_id for d in seen} == set(placed)
        for d in seen:
            at = placed[d.robot_id]
            assert hypot(1e3 * d.pose.x - at.x, 1e3 * d.pose.y - at.y) < 0.5
            assert abs(d.pose.theta - np.pi / 2) < np.radians(0.5)  # forward is up


def shrunk(image: Image, shape: tuple[int, int]) -> Image:
    """A smaller picture, each pixel the mean of what it covers."""
    blurred = cv2.GaussianBlur(image, (0, 0), 0.6 * image.shape[0] / shape[0])
    small = cv2.resize(blurred, shape[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.uint8)


def test_names_and_marks_stay_outside_the_tags() -> None:
    sheet = make_sheet(tags_scenario("vsss"), "a4")
    image = raster(printed(sheet), 0, FINE)
    for placed in sheet.pages[0]:
        low, high = tag_box(placed.printed.tag) + np.array((placed.x, placed.y))
        rows = [round((sheet.paper.height - v) * FINE) for v in (high[1], low[1])]
        columns = [round(v * FINE) for v in (low[0], high[0])]
        inside = image[rows[0] + 2 : rows[1] - 2, columns[0] + 2 : columns[1] - 2]
        assert (inside.max(axis=2) == 255).mean() < 0.6  # team colour, no white letters
        assert not (inside.min(axis=2) > 200).any()
        strip = image[rows[0] - 6 * FINE : rows[0] - FINE // 2, columns[0] : columns[1]]
        assert (strip.max(axis=2) < 100).any()  # name and arrow are there


def test_every_tag_is_printed_once_and_pages_do_not_overlap() -> None:
    for paper in PAPERS:
        sheet = make_sheet(tags_scenario("quarters"), paper.name)
        ids = [p.printed.tag.robot_id for page in sheet.pages for p in page]
        assert ids == [robot.id for robot in tags_scenario("quarters").robots]
        for page in sheet.pages:
            places = np.array([(p.x, p.y) for p in page])
            away = np.abs(places[:, None] - places).max(axis=2) + 999 * np.eye(len(places))
            assert away.min() >= 78.0 + 6.0


def test_the_same_sheet_gives_the_same_bytes() -> None:
    one, other = (sheet_pdf(make_sheet(tags_scenario("triangle"), "a4")) for _ in range(2))
    assert one == other
    assert b"CreationDate" not in one


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ConfigError, match="tags of 400 x 400 mm do not fit on a4 paper"):
        make_sheet(tags_scenario("aruco", ("tags.marker_m=0.3",)), "a4")
    with pytest.raises(ConfigError, match='no paper "a5"; there are: a4, letter'):
        paper_named("a5")


def test_the_command_prints_a_layout_or_a_scenarios_robots(tmp_path: Path) -> None:
    pdf = tmp_path / "tags.pdf"
    done = echelon("tags", "paper", "--out", pdf, "--paper", "letter")
    assert done.returncode == 0, done.stderr
    assert "3 tags on 1 page" in done.stderr
    assert len(pypdfium2.PdfDocument(pdf)) == 1
    for arguments, said in (
        (("paper", "--out", "tags.png"), "need a name that ends with .pdf"),
        (("paper", "--out", tmp_path / "gone" / "tags.pdf"), "cannot be written"),
    ):
        wrong = echelon("tags", *arguments)
        assert (wrong.returncode, len(wrong.stderr.strip().splitlines())) == (2, 1)
        assert said in wrong.stderr


def test_unknown_layouts_and_colours_are_named() -> None:
    with pytest.raises(ConfigError, match='no tag layout or scenario "nosuch"; layouts: quarters'):
        tags_scenario("nosuch")
    with pytest.raises(ConfigError, match='team = "pink" is not among'):
        make_sheet(tags_scenario("triangle", ("tags.colors.team=pink",)), "a4")
