"""Every law by its name: through rendered frames, for all followers or for one, and in `check`."""

from pathlib import Path

import pytest

from control.laws import LAW_NAMES, Law
from pipeline.checks import check_scenario
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario, scenario_path
from pipeline.setup import make_setup
from tests.pipeline.runs import run_scenario
from tests.pipeline.test_closed_loop import worst

ITS_OWN = 'colors = { rear = "blue" }'  # robot 3 of `paper`


def with_law_of_robot_3(tmp_path: Path, law: str) -> str:
    """The scenario `paper` with another law for one robot; its path."""
    path, text = tmp_path / "mixed.toml", scenario_path("paper").read_text()
    assert text.count(ITS_OWN) == 1
    path.write_text(text.replace(ITS_OWN, f'{ITS_OWN}\nlaw = "{law}"'))
    return str(path)


@pytest.mark.parametrize("law", LAW_NAMES)
def test_every_law_keeps_the_formation_through_pixels(law: str) -> None:
    """Those that switch run at 200 Hz: at 100 Hz they chatter by 0.7 to 6 deg, seed by seed."""
    switches = law in ("sampled-twisting", "suboptimal", "first-order-sign")
    period = f"control.command_period_s={0.005 if switches else 0.01}"
    changes = (f"control.law={law}", "safety.clearance_m=0", period)
    _, result, _ = run_scenario("paper", 3, changes)
    distance, bearing = worst(result)
    assert distance <= 2.0  # mm
    assert bearing <= 1.2  # deg
    assert not result.safety_events


@pytest.mark.parametrize("law", LAW_NAMES)
def test_every_law_gets_over_being_overruled(law: str) -> None:
    """The filter holds both followers for a second; what is left is their later start."""
    period = "control.command_period_s=0.005"  # at which all of them are at home
    _, result, _ = run_scenario("paper", 3, (f"control.law={law}", period))
    distance, bearing = worst(result)
    assert distance <= 10.0  # mm
    assert bearing <= 6.0  # deg
    assert result.min_clearance_m is not None
    assert 1e3 * result.min_clearance_m >= 20.0


def test_a_robot_may_have_a_law_of_its_own(tmp_path: Path) -> None:
    mixed = with_law_of_robot_3(tmp_path, "super-twisting")
    setup = make_setup(load_scenario(mixed))
    assert [setup.gains[robot].law for robot in (2, 3)] == [
        Law.IMPLICIT_TWISTING,
        Law.SUPER_TWISTING,
    ]
    _, result, _ = run_scenario(mixed, 3)
    assert worst(result)[0] <= 2.0


def test_check_judges_every_law_by_its_period(tmp_path: Path) -> None:
    mixed = with_law_of_robot_3(tmp_path, "suboptimal")
    for period, holds in ((0.01, True), (0.02, False)):
        scenario = load_scenario(mixed, (f"control.command_period_s={period}",))
        found = [f for f in check_scenario(scenario) if f.topic == "sampling"]
        assert [f.holds for f in found] == [True, holds]
        assert "robot 2" in found[0].detail
        assert "suboptimal" in found[1].detail


def test_an_unknown_law_is_named_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"mixed.toml:\d+: .*no law 'magic'; there are: implicit"):
        load_scenario(with_law_of_robot_3(tmp_path, "magic"))
