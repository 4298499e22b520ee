"""`echelon calibrate`: from files to a fragment that a scenario includes, and every refusal."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from control.errors import EchelonError
from pipeline.calibration.board_file import DEFAULT_BOARD, board_text, read_board
from pipeline.calibration.fragment import read_lens
from pipeline.calibration.pictures import camera_frames, gather_views
from pipeline.calibration.point_file import read_points
from pipeline.calibration.sheet import PAPERS, print_board
from pipeline.camera_model import make_camera
from pipeline.cli.calibrate import calibrate
from pipeline.errors import ConfigError
from pipeline.rigs import make_renderer
from pipeline.scenario import load_scenario, scenario_path
from pipeline.setup import make_setup
from tests.pipeline.commands import echelon
from tests.vision.filmed_boards import (
    BOARD,
    PLACES,
    film,
    flat_pose,
    floor_errors,
    held_poses,
    tilted,
)
from vision.calibration.board import Board
from vision.calibration.detect import BoardView, find_board

TEXT = board_text(BOARD)


def calibrate_here(*arguments: object) -> tuple[str, Exception | None]:
    """`echelon calibrate` in this process: what it says, and its error."""
    done = CliRunner().invoke(calibrate, [str(argument) for argument in arguments])
    failed = isinstance(done.exception, Exception)
    return done.stdout, done.exception if failed else None  # type: ignore[return-value]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of views, among them a damaged and an odd-sized image; and floor pictures."""
    folder = tmp_path_factory.mktemp("board")
    filmed = film(tilted())
    for name, poses in (
        ("views", held_poses(tilted(), 11)[1:]),
        ("floor", [flat_pose(*place) for place in PLACES[:3]]),
    ):
        (folder / name).mkdir()
        for number, pose in enumerate(poses):
            picture = filmed.picture(*pose, number)
            cv2.imwrite(str(folder / name / f"{name}{number}.png"), picture)
    (folder / "views" / "damaged.png").write_bytes(b"\x89PNG\r\n\x1a\nno more")
    cv2.imwrite(str(folder / "views" / "small.png"), np.zeros((90, 160, 3), np.uint8))
    cv2.imwrite(str(folder / "views" / "empty.png"), np.zeros((480, 640, 3), np.uint8))
    return folder


@pytest.fixture(scope="module")
def fragment(pictures: Path) -> Path:
    """What the command writes."""
    out = pictures / "camera.toml"
    done = echelon(
        "calibrate", "camera", pictures / "views", "--board", TEXT, "--floor", pictures / "floor",
        "--tag-height", 75, "--out", out, "--overlay", pictures / "seen", "--json",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["floor"]["camera_height_m"] == pytest.approx(1.45, abs=2e-3)
    assert result["floor"]["expected_rms_mm"] < 1.0
    assert result["lens"]["reprojection_px"] < 0.03
    assert len(result["views"]) >= 12
    unused = " ".join(result["unused"])
    assert "damaged.png" in unused
    assert "small.png: is 160 x 90 px, the others 640 x 480 px" in unused
    assert "empty.png: no marker of dictionary 4x4_100 is seen" in unused
    return out


def scenario(folder: Path, more: str = "", name: str = "mine") -> Path:
    """The paper's scenario with the fragment."""
    path = folder / f"{name}.toml"
    paper = scenario_path("paper")
    path.write_text(f'include = ["{paper}", "camera.toml"]\nname = "{name}"\n{more}')
    return path


def test_the_fragment_is_the_camera(pictures: Path, fragment: Path) -> None:
    assert fragment.is_file()
    loaded = load_scenario(str(scenario(pictures)))
    camera = make_camera(loaded.camera)
    off = floor_errors(camera, tilted())
    assert np.sqrt(np.mean(off**2)) < 3e-3  # ten views, none in the image's corners
    assert camera.tag_height == 0.075
    assert make_setup(loaded).seeing.floor_known
    for name in ("coverage.png", "floor.png", "corners_views3.png", "corners_floor_floor1.png"):
        assert cv2.imread(str(pictures / "seen" / name)) is not None, name


def test_a_fragment_for_another_resolution_is_refused_or_scaled(
    pictures: Path, fragment: Path
) -> None:
    path = str(scenario(fragment.parent))
    small = ["camera.width_px=320", "camera.height_px=240"]
    with pytest.raises(ConfigError, match=r"640 x 480 px.* 320 x 240 px.*other_sizes"):
        make_setup(load_scenario(path, [*small, "camera.other_sizes=refuse"]))
    camera = make_setup(load_scenario(path, [*small, "camera.other_sizes=scale"])).camera
    assert camera.size_px == (320, 240)
    off = floor_errors(camera, tilted().scaled_to((320, 240)))
    assert np.sqrt(np.mean(off**2)) < 3e-3
    assert pictures


def test_only_the_floor_is_new(pictures: Path, fragment: Path) -> None:
    out = pictures / "again.toml"
    stdout, error = calibrate_here(
        "camera", "--lens", fragment, "--board", TEXT, "--out", out, "--json",
        "--floor", pictures / "floor" / "floor1.png", "--floor", pictures / "floor" / "floor2.png",
    )  # fmt: skip
    assert error is None
    assert json.loads(stdout)["lens"]["reprojection_of_views_left_out_px"] is None
    np.testing.assert_allclose(read_lens(out)[0], read_lens(fragment)[0], atol=1e-3)


def test_known_points_from_a_file(pictures: Path, fragment: Path) -> None:
    places = np.array([(x, y, 0.075) for x in (-0.6, 0.0, 0.6) for y in (-0.3, 0.35)])
    pixels = tilted().project(places)
    rows = [
        f"{x:.4f}, {y:.4f}, {z}, {u:.2f}, {v:.2f}"
        for (x, y, z), (u, v) in zip(places.tolist(), pixels.tolist(), strict=True)
    ]
    table = pictures / "points.csv"
    table.write_text("\n".join(["x_m, y_m, z_m, x_px, y_px", *rows]))
    out = pictures / "pointed.toml"
    arguments = ("calibrate", "camera", "--lens", fragment, "--points", table, "--out", out)
    stdout, error = calibrate_here(*arguments[1:])
    assert error is None
    assert "6 known points" in stdout
    x, y, *rest = rows[4].split(", ")
    table.write_text("\n".join(["x_m, y_m, z_m, x_px, y_px", *rows[:4], ", ".join((y, x, *rest)),
                                rows[5]]))  # fmt: skip
    done = echelon(*arguments)
    assert done.returncode == 2
    assert "point 5" in done.stderr
    assert "x and y swapped?" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_without_a_floor_there_are_pixels_only(pictures: Path, fragment: Path) -> None:
    lens = pictures / "lens" / "camera.toml"
    lens.parent.mkdir()
    text = fragment.read_text().split("[camera.floor]")[0]
    lens.write_text(text.replace("tag_height_m", 'floor = "unknown"\ntag_px = 10.2\ntag_height_m'))
    path = scenario(lens.parent)
    image = lens.parent / "frames"
    assert echelon("render", "paper", "--out", image, "--duration", 0.1).returncode == 0
    own = scenario(lens.parent, '[camera]\nfloor = "unknown"\ntag_px = 10.2\n', "plain")
    own.write_text(own.read_text().replace(', "camera.toml"', ""))
    done = echelon("locate", image / "frame_00000.png", "--setup", own, "--json")
    assert done.returncode == 0, done.stderr
    (found,) = json.loads(done.stdout)["images"]
    assert {d["id"] for d in found["detections"]} == {1, 2, 3}
    for seen in found["detections"]:
        assert (seen["x_m"], seen["y_m"], seen["theta_rad"]) == (None, None, None)
        assert seen["x_px"] > 0.0
    assert not make_setup(load_scenario(str(path))).seeing.floor_known
    done = echelon("live", path, "--fast")
    assert done.returncode == 2, done.stdout
    assert "live: the camera's floor is unknown" in done.stderr
    assert "calibrate camera" in done.stderr
    with pytest.raises(ConfigError, match="rendered camera: the camera's floor is unknown"):
        make_renderer(load_scenario(str(own)))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "need a SOURCE"),
        (("gone",), "gone"),
        (("{views}", "--board", "charuco:8x5"), 'need "charuco:8x5:35:25"'),
        (("{views}", "--board", "charuco:8x5:25:35"), "do not fit into squares"),
        (("{views}", "--board", "chessboard:2x5:25"), "need 3 to 60 either way"),
        (("{views}", "--board", "charuco:9x7:30:20:6x6_250"), "0 views show the board"),
        (("{views}", "--floor", "gone.png"), "gone.png"),
        (("{views}", "--floor", "a.png", "--points", "b.csv"), "name one"),
        (("{views}", "--lens", "x.toml"), "name one"),
        (("--lens", "x.toml"), "name --floor or --points"),
        (("--lens", "{views}/views0.png", "--points", "gone.csv"), "cannot be read"),
        (("rendered",), "rendered camera needs no calibration"),
    ],
)
def test_wrong_use_is_one_clear_line(pictures: Path, arguments: tuple[str, ...], said: str) -> None:
    few = pictures / "few"
    few.mkdir(exist_ok=True)
    for name in ("views0.png", "views1.png"):
        (few / name).write_bytes((pictures / "views" / name).read_bytes())
    _, error = calibrate_here("camera", *(a.format(views=few) for a in arguments))
    assert isinstance(error, EchelonError), error
    assert said in str(error)


def test_a_printed_board_has_its_size_and_is_found(tmp_path: Path) -> None:
    paper = "a4"
    board = Board(square=0.032, marker=0.023)
    for name in ("board.pdf", "board.png"):
        print_board(board, paper, tmp_path / name)
    page = (tmp_path / "board.pdf").read_bytes()
    width, height = (side / 25.4 * 72 for side in PAPERS[paper])
    box = re.search(rb"/MediaBox \[ ?0 0 ([0-9.]+) ([0-9.]+)", page)
    assert box is not None
    assert [float(side) for side in box.groups()] == pytest.approx([width, height], abs=0.01)
    print_board(board, paper, tmp_path / "twice.pdf")
    assert (tmp_path / "twice.pdf").read_bytes() == page
    image = cv2.imread(str(tmp_path / "board.png"))
    assert image is not None
    assert image.shape[0] == pytest.approx(300 * PAPERS[paper][1] / 25.4, abs=1)
    small = np.asarray(cv2.resize(image, None, fx=0.4, fy=0.4, interpolation=cv2.INTER_AREA))
    view = find_board(small.astype(np.uint8), board)
    assert isinstance(view, BoardView)
    assert len(view.ids) == 28
    side = np.diff(view.pixels.reshape(4, 7, 2)[:, :, 0], axis=1).mean()
    assert side == pytest.approx(120 / 25.4 * 32.0, rel=3e-4)


def test_a_board_that_does_not_fit_the_paper_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"does not fit a4 .* squares of 35 mm would"):
        print_board(BOARD, "a4", tmp_path / "board.pdf")
    with pytest.raises(ConfigError, match='no paper "a9"'):
        print_board(BOARD, "a9", tmp_path / "board.pdf")


def test_boards_are_written_and_read(tmp_path: Path) -> None:
    for text in (DEFAULT_BOARD, "chessboard:10x7:25", "charuco:6x4:60:45:5x5_100:legacy"):
        board = read_board(text)
        assert read_board(board_text(board)) == board
    file = tmp_path / "mine.toml"
    file.write_text('kind = "chessboard"\ncolumns = 9\nrows = 6\nsquare_mm = 24.9\n')
    assert read_board(str(file)).square == pytest.approx(0.0249)
    file.write_text("columns = 9\nrow = 6\n")
    with pytest.raises(ConfigError, match=r"mine\.toml"):
        read_board(str(file))


def test_point_files_name_what_is_wrong(tmp_path: Path) -> None:
    good = tmp_path / "good.toml"
    good.write_text('[[points]]\nname = "A"\nx_m = 1\ny_m = 2\nx_px = 3\ny_px = 4\n')
    (point,) = read_points(good)
    assert (point.name, point.floor, point.pixel) == ("A", (1.0, 2.0, 0.0), (3.0, 4.0))
    table = tmp_path / "points.csv"
    for text, said in (
        ("x_m,y_m,x_px,y_px\n1,2,3,4\n1,zwei,3,4\n", r'point 2: y_m = "zwei" is not a number'),
        ("x_m,y_m,x_px\n1,2,3\n", "point 1: y_px is missing"),
        ("x_m,y_m,x_px,y_px,hight\n1,2,3,4,5\n", 'unknown key "hight"'),
        ("", "holds no points"),
        ("x_m;y_m;x_px;y_px\n1;nan;3;4\n", "not a sensible number"),
    ):
        table.write_text(text)
        with pytest.raises(ConfigError, match=said):
            read_points(table)


def test_views_are_chosen_from_a_video(tmp_path: Path) -> None:
    from datasets.recorded import VideoWriter
    from vision.frame import as_frame

    filmed, poses = film(tilted()), held_poses(tilted(), 7)[4:7]
    writer, number = VideoWriter(tmp_path / "board.mp4", 30.0), 0
    for pose in poses:
        for _ in range(3):
            writer.write(as_frame(filmed.picture(*pose, number), number / 30.0, number))
            number += 1
    writer.close()
    gathered = gather_views(str(tmp_path / "board.mp4"), BOARD, 6, None, lambda: False)
    assert [view.name for view in gathered.views] == ["frame 1", "frame 4", "frame 7"]
    live = list(camera_frames(str(tmp_path / "board.mp4"), None, lambda: False))
    assert 1 <= len(live) <= number
    assert list(camera_frames(str(tmp_path / "board.mp4"), None, lambda: True)) == []
    assert set(gathered.images) == {view.name for view in gathered.views}
