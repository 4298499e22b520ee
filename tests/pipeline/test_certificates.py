"""Certificates of scenarios: what fails a check and what is only told, warnings, the picture."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import typer

from control.laws import LAW_NAMES
from control.relative import relative_state
from control.unicycle import advance_pose
from datasets.recorded import SessionWriter
from pipeline.certificate_findings import broken_gains, certificate_findings
from pipeline.certificates import Certificates, make_certificates, start_states
from pipeline.checks import check_scenario
from pipeline.cli.check import check
from pipeline.cli.checking import write_omega
from pipeline.cli.output import Output
from pipeline.cli.running import Outputs, Request, header_of, run_live
from pipeline.errors import ConfigError
from pipeline.finding import Finding
from pipeline.report.omega import run_errors, run_starts
from pipeline.report.series import Collector, Series
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from tests.datasets.recorded_moments import moments


def certified(name: str, *overrides: str) -> tuple[Setup, Certificates]:
    """The certificates of a scenario."""
    scenario = load_scenario(name, overrides)
    setup = make_setup(scenario)
    return setup, make_certificates(setup, start_states(scenario, setup))


def found(name: str, *overrides: str) -> dict[str, Finding]:
    """What the certificates of a scenario say, by topic."""
    setup, made = certified(name, *overrides)
    return {finding.topic: finding for finding in certificate_findings(made, setup)}


def test_the_paper_s_gains_do_for_exact_robots_and_are_told_to_go_no_further() -> None:
    told = found("paper")
    for robot in (2, 3):
        assert told[f"gains {robot}"].holds
        assert told[f"gains {robot}"].binding
        for topic in ("certificate", "all of omega"):
            assert not told[f"{topic} {robot}"].holds
            assert not told[f"{topic} {robot}"].binding
            assert "not guaranteed" in told[f"{topic} {robot}"].detail
    assert "nu 4 > 2.22, mu 20 > 8.45 rad/s^2 (bearing)" in told["gains 2"].detail
    assert "no mu and nu (mu 24.2, nu 7.21 if neither" in told["certificate 3"].detail
    assert "model errors of 0.66 %" in told["certificate 2"].detail
    assert "1.25 rad/s at 2.60, 5.12 s" in told["smooth plan"].detail


def test_what_holds_is_guaranteed_between_the_plan_s_jumps() -> None:
    told = found("paper", "control.model_error=0.0")
    assert told["certificate 3"].holds
    assert told["certificate 3"].detail.startswith("guaranteed between the plan's jumps")
    assert "each alone would do" not in told["certificate 3"].detail


@pytest.mark.parametrize("name", ["paper", "moving-start", "cascade", "shapes", "diamond", "aruco"])
def test_no_shipped_scenario_has_broken_gains(name: str) -> None:
    scenario = load_scenario(name)
    assert broken_gains(scenario, make_setup(scenario)) == ()


@pytest.mark.parametrize("law", LAW_NAMES)
def test_every_law_is_told_its_own_conditions(law: str) -> None:
    told = found("paper", f"control.law={law}")["gains 3"]
    gain = "Lip 10" if law == "super-twisting" else "eta 0.5" if "first" in law else "nu 4"
    assert f"{law} for exact robots" in told.detail
    assert gain in told.detail
    assert told.binding is (law != "super-twisting")  # nothing bounds the rate of a jump


def test_gains_too_small_for_exact_robots_fail_a_check_and_warn_in_live(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(typer.Exit) as done:
        check("paper", overrides=["control.nu=2"])
    assert done.value.exit_code == 2
    told = capsys.readouterr().out
    assert "FAILS  gains 2: " in told
    assert "nu 2 <= 2.22" in told
    request = Request("paper", fast=True, duration=0.1, overrides=("control.nu=2",))
    run_live(request, Outputs(), Output(as_json=False))
    assert "warning: gains 3: " in capsys.readouterr().out


def test_a_plan_that_leaves_the_picture_fails_a_check_and_warns_in_live(
    capsys: pytest.CaptureFixture[str],
) -> None:
    narrow = ("camera.field_width_m=1.9",)
    inside, outside = (
        next(f for f in check_scenario(load_scenario("paper", how)) if f.topic == "field of view")
        for how in ((), narrow)
    )
    assert inside.holds
    assert not outside.holds
    assert "leaves the picture after 3.5 s, by up to 31 px" in outside.detail
    run_live(Request("paper", fast=True, duration=0.1, overrides=narrow), Outputs(), Output(False))
    assert f"warning: {outside.detail}" in capsys.readouterr().out
    run_live(Request("paper", fast=True, duration=0.1), Outputs(), Output(as_json=False))
    assert "warning" not in capsys.readouterr().out


def test_a_pair_without_known_starts_begins_in_its_shape() -> None:
    scenario = load_scenario("paper")
    setup = make_setup(scenario)
    second, third = make_certificates(setup, {}).pairs
    for pair in (second, third):
        assert pair.certificate is not None
        assert pair.certificate.omega.bounds == (0.02, 0.1)
    some = start_states(scenario, setup)
    assert make_certificates(setup, {2: some[2]}).pairs[0].certificate == second.certificate


def test_robots_that_drive_already_begin_with_their_rates() -> None:
    scenario = load_scenario("moving-start")
    setup = make_setup(scenario)
    states = start_states(scenario, setup)
    course = make_certificates(setup, states).pairs[0].course
    assert course is not None
    now, soon = (
        relative_state(*(advance_pose(states[k].pose, states[k].twist, dt) for k in (1, 2)), 0.05)
        for dt in (0.0, 1e-5)
    )
    rates = (soon.distance - now.distance) / 1e-5, (soon.bearing - now.bearing) / 1e-5
    assert -course.error[1, :, 0] == pytest.approx(rates, abs=1e-4)
    assert states[1].x == pytest.approx(-0.162 + 0.5 * 0.3)  # watched for half a second


def test_who_has_no_certificate_is_told_why() -> None:
    assert found("diamond")["certificate 4"].detail == "no certificate: it follows two robots"
    near = ("robots.2.start.x_m=-0.22", "robots.2.start.y_m=0.151", "robots.4.start.x_m=-0.24")
    told = found("cascade", *near, "robots.4.start.y_m=0.151")
    assert "comes within" in told["certificate 4"].detail
    assert told["certificate 6"].detail == "no certificate: there is none for its leader"


def run_in(path: Path, name: str = "paper") -> tuple[Path, Series]:
    """A recorded run on its nominal path, and its series."""
    scenario = load_scenario(name)
    collector = Collector(make_setup(scenario))
    writer = SessionWriter(path, header_of(scenario, 0), True)
    for moment in moments(3.0):
        writer.observe(moment)
        collector.observe(moment)
    writer.close()
    return path, collector.series()


def test_a_run_lies_on_the_nominal_path_from_its_own_start(tmp_path: Path) -> None:
    _, series = run_in(tmp_path / "s.mcap")
    setup = make_setup(load_scenario("paper"))
    made, runs = make_certificates(setup, run_starts(series)), run_errors(series, setup)
    for pair in made.pairs:
        course, run = pair.course, runs[pair.pair.follower]
        assert course is not None
        times = series.times[series.times >= 0.0]
        for channel, error in enumerate(course.error[0]):
            nominal = np.interp(times, course.times, error)
            assert run[:, channel] == pytest.approx(nominal, abs=2e-3)


def test_the_picture_shows_a_session_of_the_same_formation(tmp_path: Path) -> None:
    session, _ = run_in(tmp_path / "s.mcap")
    scenario = load_scenario("paper")
    plain = cv2.imread(str(write_omega(scenario, tmp_path / "plain", None)))
    drawn = cv2.imread(str(write_omega(scenario, tmp_path / "drawn", session)))
    assert plain is not None
    assert drawn is not None
    assert plain.shape == drawn.shape
    changed = np.abs(plain.astype(int) - drawn).max(axis=2) > 20
    assert 0.002 < changed.mean() < 0.1  # the run's path and its entry in the legend
    with pytest.raises(ConfigError, match="its formation is not that of scenario cascade"):
        write_omega(load_scenario("cascade"), tmp_path, session)
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be written"):
        write_omega(scenario, tmp_path / "file" / "out", None)


def test_a_session_without_a_folder_is_refused() -> None:
    with pytest.raises(ConfigError, match="--out DIR"):
        check("paper", session=Path("s.mcap"))
