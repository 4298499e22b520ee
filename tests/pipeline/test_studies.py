"""Studies: what they find (bounds, not curves), and the files and errors of `echelon study`."""

import csv
import json
import re
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

import pipeline.studies.all
from control.laws import Law
from pipeline.cli.main import app
from pipeline.errors import ConfigError
from pipeline.studies.all import STUDIES, study_named
from pipeline.studies.differentiators import Differentiators
from pipeline.studies.files import make_folder, write_result
from pipeline.studies.laws_compared import LawsCompared
from pipeline.studies.paper import PaperAgain
from pipeline.studies.robustness import Robustness
from pipeline.studies.sampled_twisting import SampledTwisting
from pipeline.studies.study import Cell, Result, Study
from pipeline.studies.twisting_laws import TwistingLaws
from tests.control.test_twisting import left_over
from tests.pipeline.commands import ECHELON, ROOT

FRAME = 1000.0 / 30.0  # ms
SMALL: tuple[Study, ...] = (
    PaperAgain(runs=2),
    SampledTwisting(periods=(5.0, 12.0, 60.0)),
    TwistingLaws(periods=(20.0, 60.0), runs=1),
    LawsCompared(periods=(5.0, 60.0), runs=2),
    Robustness((0.0, 20.0, 50.0), (40.0,), (1.0,), (0.0, 20.0, 70.0), runs=2),
    Differentiators(periods=(FRAME, 60.0), noises=(0.1, 1.0), until=20.0, runs=1),
)
UNITLESS = {"method", "order", "law", "statement", "paper", "unit", "holds", "map", "noise_factor"}
INK = {"robustness": 0.95}  # coloured maps; curves and text leave half of a picture white


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    return {study.name: study.run(lambda _: None) for study in SMALL}


def value(result: Result, *key: Cell) -> float:
    """The first number of the row that begins with a key."""
    (row,) = (row for row in result.rows if row[: len(key)] == key)
    assert isinstance(row[len(key)], float)
    return float(row[len(key)])  # type: ignore[arg-type]


def test_every_study_is_tried_here() -> None:
    assert [study.name for study in SMALL] == [study.name for study in STUDIES]


@pytest.mark.parametrize("study", SMALL, ids=lambda study: study.name)
def test_figure_and_table(study: Study, results: dict[str, Result], tmp_path: Path) -> None:
    result = results[study.name]
    picture, table = write_result(result, study.name, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {picture.name, table.name}
    image = cv2.imread(str(picture))
    assert image is not None
    assert min(image.shape[:2]) >= 600
    inked = np.any(image.reshape(-1, 3) < 200, axis=1).mean()
    assert 0.01 < inked < INK.get(study.name, 0.5)
    with table.open(newline="") as file:
        header, *rows = csv.reader(file)
    numbers = [name for name in header if name not in UNITLESS]
    assert numbers
    assert all(re.search(r"_(ms|mm|mmps|deg|percent|radps_per_s)$", name) for name in numbers)
    assert len(rows) == len(result.rows) > 5
    assert all(len(row) == len(header) for row in rows)
    assert [row[-1] for row in rows] == [str(row[-1]) for row in result.rows]


@pytest.mark.parametrize("study", SMALL, ids=lambda study: study.name)
def test_progress_grows_and_may_end_the_study(study: Study) -> None:
    class Enough(Exception):
        pass

    shares: list[float] = []

    def _progress(share: float) -> None:
        shares.append(share)
        if len(shares) == 3:
            raise Enough

    with pytest.raises(Enough):
        study.run(_progress)
    assert 0.0 <= shares[0] <= shares[1] <= shares[2] <= 1.0


def test_what_differentiators_leave(results: dict[str, Result]) -> None:
    # mm/s; the table of the design is 30, 23, 1.2 and 22 at 60 ms; 17, 7.5, 0.4 and 6.7 at 1/30 s
    error = {
        (method, order, period): value(results["differentiators"], method, order, period, 0.0)
        for method, order in (("implicit", 2), ("implicit", 3), ("explicit", 2),
                              ("Savitzky-Golay", 2), ("backward difference", 1))
        for period in (FRAME, 60.0)
    }  # fmt: skip
    limits = {
        "backward difference": (17.0, 30.5), "explicit": (8.0, 24.0), "Savitzky-Golay": (7.0, 22.0),
    }  # fmt: skip
    for (method, order, period), found in error.items():
        column = int(period == 60.0)
        if method == "implicit":
            assert found < ((0.4, 1.25) if order == 2 else (0.02, 0.1))[column]
        else:
            assert 0.8 * limits[method][column] < found < limits[method][column]
    for order in range(2, 6):
        one, other = (
            value(results["differentiators"], form, order, 60.0, 1.0)
            for form in ("implicit", "explicit")
        )
        assert 10.0 < one < 40.0
        assert 10.0 < other < 90.0


def test_where_the_published_law_works(results: dict[str, Result]) -> None:
    def _error(law: str, period: float) -> float:
        return value(results["sampled-twisting"], law, period)

    published = "as published, (27) and (31)"
    assert _error(published, 5.0) < 3.0  # mm: works to 2 mm
    assert _error(published, 12.0) > 50.0  # a follower is lost
    assert _error(published, 60.0) > 50.0
    assert _error("sampled-twisting", 12.0) < 20.0  # not lost yet
    assert _error("sampled-twisting", 60.0) > 50.0
    for period in (5.0, 12.0, 60.0):
        assert _error("implicit-twisting", period) < 1.5


def test_the_papers_statements_hold_at_both_periods(results: dict[str, Result]) -> None:
    rows = results["paper"].rows
    assert [row[0] for row in rows if row[-1] != "yes"] == []
    greatest = next(row for row in rows if str(row[0]).startswith("R3 accelerates"))
    assert all(0.85 < float(speed) < 1.05 for speed in greatest[3:5])  # type: ignore[arg-type]


def test_laws_side_by_side(results: dict[str, Result]) -> None:
    found = {(row[0], row[1]): [float(cell) for cell in row[2:]] for row in results["laws"].rows}  # type: ignore[arg-type]
    for law in Law:
        distance, bearing, *_ = found[law.title, 5.0]
        assert distance < 4.0  # mm
        assert bearing < (10.0 if law == Law.SAMPLED_TWISTING else 1.5)  # deg
    smooth = ("implicit-twisting", "compensated-twisting", "first-order-implicit", "super-twisting")
    for title in smooth:
        distance, bearing, *_ = found[title, 60.0]
        assert distance < 4.0  # mm
        assert bearing < 3.0  # deg
    assert (
        found["first-order-implicit", 5.0][2] < 0.1 * found["first-order-sign", 5.0][2]
    )  # chatter
    assert found["sampled-twisting", 60.0][0] > 30.0  # mm: lost


def test_what_breaks_the_design_and_what_does_not(results: dict[str, Result]) -> None:
    cells = {row[:5]: row[5] for row in results["robustness"].rows}
    for mass in (0.0, 20.0, 50.0):
        assert float(cells["mass-latency", mass, 40.0, 1.0, 0.0] or 99.0) < 2.5  # mm
    lost = cells["noise-loss", 10.0, 40.0, 1.0, 70.0]
    assert lost is None or float(lost) > 20.0
    assert float(cells["noise-loss", 10.0, 40.0, 1.0, 20.0] or 99.0) < 3.0


def test_what_twisting_leaves_at_60_ms(results: dict[str, Result]) -> None:
    def _left(law: str, noise: float, period: float = 60.0) -> float:
        return value(results["twisting-laws"], law, period, noise)

    # mm; the design says 212, 12.6 and 0.81, with 1 mm of noise 211, 15.1 and 7.5
    assert 100.0 < _left("sampled-twisting", 0.0) < 300.0
    assert 100.0 < _left("suboptimal", 0.0) < 300.0
    assert _left("implicit-twisting", 0.0) == pytest.approx(12.6, abs=0.1)
    stepwise = 1e3 * left_over(Law.IMPLICIT_TWISTING, 0.06, 0.0, 40.0)  # in 60 parts a period
    assert _left("implicit-twisting", 0.0) == pytest.approx(stepwise, abs=5e-4)
    assert _left("compensated-twisting", 0.0) == pytest.approx(0.81, abs=0.01)
    assert 13.0 < _left("implicit-twisting", 1.0) < 18.0
    assert 3.0 < _left("compensated-twisting", 1.0) < 9.0
    # of the order of the period squared, with the disturbance estimated cubed
    for law, power in (("implicit-twisting", 2.0), ("compensated-twisting", 3.0)):
        ratio = _left(law, 0.0) / _left(law, 0.0, 20.0)
        assert ratio == pytest.approx(3.0**power, rel=0.1)


def test_files_that_cannot_be_written_are_one_clear_error(tmp_path: Path) -> None:
    taken = tmp_path / "file"
    taken.touch()
    for folder in (taken, taken / "below"):
        with pytest.raises(ConfigError, match=r"--out .*file.*cannot be written"):
            make_folder(folder)
    with pytest.raises(ConfigError, match="cannot be written"):
        write_result(Result(("a_mm",), ((1.0,),), lambda: None), "x", taken)  # type: ignore[arg-type,return-value]
    with pytest.raises(ConfigError, match='no study "robust"; there are: paper'):
        study_named("robust")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """`echelon study` in this process, with the small studies."""
    monkeypatch.setattr(pipeline.studies.all, "STUDIES", SMALL)
    return lambda *arguments: CliRunner().invoke(app, ["study", *map(str, arguments)])


def test_the_command_lists(run: Callable[..., Any]) -> None:
    for study, line in zip(STUDIES, run().stdout.splitlines(), strict=True):
        assert line.split()[0] == study.name
        assert study.summary in line
    named = json.loads(run("--json").stdout)["studies"]
    assert named == {study.name: study.summary for study in STUDIES}


def test_the_command_writes_and_tells(run: Callable[..., Any], tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    found = json.loads(run("twisting-laws", "--out", folder, "--json").stdout)
    assert found["study"] == "twisting-laws"
    assert {len(row) for row in found["rows"]} == {len(found["columns"])}
    assert Path(found["figure"]).stat().st_size > 10_000
    files = [Path(found[key]).read_bytes() for key in ("figure", "table")]
    told = run("twisting-laws", "--out", folder).stdout.splitlines()
    assert told == [f"figure: {found['figure']}", f"table: {found['table']} (16 rows)"]
    assert files == [Path(found[key]).read_bytes() for key in ("figure", "table")]  # bit for bit


def test_wrong_use_is_a_clear_error(run: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for arguments, words in (
        (("robust", "--out", tmp_path), 'no study "robust"; there are: paper'),
        (("differentiators",), "needs --out DIR"),
        (("differentiators", "--out", tmp_path / "file"), "cannot be written"),
    ):
        error = run(*arguments).exception
        assert isinstance(error, ConfigError)
        assert words in str(error)


def test_ctrl_c_ends_with_130_and_leaves_no_half_files(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*ECHELON, "study", "differentiators", "--out", str(tmp_path / "out")],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and not (tmp_path / "out").exists():
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30.0)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert not list((tmp_path / "out").iterdir())
