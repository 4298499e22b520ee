"""From the scenario file to sensor and surroundings: every key arrives, wrong ones are named."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import ConfigError
from pipeline.filming import make_renderer, make_surroundings, sensor_model
from pipeline.rigs import make_world
from pipeline.scenario import load_scenario, scenario_names, scenario_path
from pipeline.sensor_config import SensorConfig

THING = '{{ shape = "{}", color = "red", points = [{{ x_m = 0.5, y_m = 0.4 }}], {} }}'


def test_every_key_of_the_sensor_changes_the_sensor() -> None:
    other = {
        "read_noise": 1.0, "blur_px": 1.0, "uneven_light": 0.5, "vignetting_power": 4.0,
        "exposure_s": 0.01, "readout_s": 0.02, "exposure_changes": [{"at_s": 1, "factor": 2}],
        "flicker_depth": 0.5, "flicker_hz": 120.0, "full_well_e": 5000, "hot_pixel_share": 0.01,
        "white_balance_changes": [{"at_s": 1, "red": 2}], "bayer": "RGGB", "gamma": 2.0,
        "chroma": "444", "chroma_upsampling": "nearest", "chroma_offset_px": (0.5, 0.0),
        "jpeg_quality": 80,
    }  # fmt: skip
    assert set(other) == set(SensorConfig.model_fields)
    usual = sensor_model(SensorConfig())
    for key, value in other.items():
        assert sensor_model(SensorConfig.model_validate({key: value})) != usual, key
    white = SensorConfig.model_validate({"white_balance_changes": [{"at_s": 1, "red": 2}]})
    assert sensor_model(white).white_balance_changes[0].gains == (1.0, 1.0, 2.0)  # BGR


@pytest.mark.parametrize("name", scenario_names())
def test_the_same_seed_gives_the_same_picture(name: str) -> None:
    scenario = load_scenario(name)
    states = make_world(scenario).truth()
    one, same, other = (
        make_renderer(scenario, seed).render(states, t)
        for seed, t in ((3, 2.5), (3, 2.5), (4, 2.5))
    )
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('clutter = { count = 3, colors = ["mauve"] }', '"mauve" is not among'),
        ("clutter = { count = 3, colors = [] }", "surroundings.clutter.colors"),
        ('clutter = { count = 3, colours = ["red"] }', 'did you mean "colors"?'),
        ('clutter = { count = 3, colors = ["red"], size_m = [0.2, 0.1] }', "from the smallest"),
        (f"things = [{THING.format('hnd', 'size_m = 0.1')}]", "surroundings.things.0"),
        (f"things = [{THING.format('cable', 'size_m = 0.01')}]", "needs line_m"),
        (f"things = [{THING.format('outline', 'size_m = 0.01')}]", "needs outline_m"),
        ('things = [{ shape = "hand", color = "red" }]', "either points, or wander"),
        ("shadows = [{ radius_m = 0.2, points = [{ at_s = 1, x_m = 0, y_m = 0 }, "
         "{ at_s = 1, x_m = 1, y_m = 0 }] }]", "must ascend"),
        ("glares = [{ x_m = 0.1, y_m = 0.2, widht_m = 0.1 }]", 'did you mean "width_m"?'),
    ],
)  # fmt: skip
def test_wrong_surroundings_are_named(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "mine.toml"
    paper = scenario_path("paper")
    path.write_text(f'include = ["{paper}"]\nname = "mine"\n[surroundings]\n{text}\n')
    with pytest.raises(ConfigError) as error:
        make_surroundings(load_scenario(str(path)))
    assert expected in str(error.value)
    assert "\n" not in str(error.value)
