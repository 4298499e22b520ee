"""What was lost is told: by name, with its number, and only where something was lost."""

from dataclasses import replace

import pytest

from control.command import Command
from control.unicycle import Twist
from pipeline.accounts import account
from pipeline.cli.output import Output
from pipeline.cli.running import Outputs, Request, run_live
from pipeline.radios.none import NoRadio
from pipeline.rigs import Tee, connect
from pipeline.scenario import load_scenario
from tests.pipeline.runs import Keeper

PAPER = load_scenario("paper")


class Behind(Keeper):
    """An observer that could not keep up."""

    dropped = 7


def test_nothing_lost_nothing_said() -> None:
    rig = connect(PAPER, "rendered", None, 0, True)
    rig.source.latest(0.1)
    assert account(replace(rig, observers=(Keeper(),))) == (
        "camera: 1 frames were passed over for newer ones",
    )
    assert account(connect(PAPER, "rendered", None, 0, True)) == ()


def test_the_table_of_a_run_begins_its_latencies_with_the_camera(
    capsys: pytest.CaptureFixture[str],
) -> None:
    run_live(Request("paper", duration=1.0, fast=True), Outputs(), Output(False))
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    start = lines.index("stage median ms 99 % ms")
    assert lines[start - 1] == "Latency"
    assert lines[start + 1] == "capture to arrival 40.00 40.00"  # as the scenario says
    assert lines[start + 2].startswith("vision ")


def test_every_loss_is_named() -> None:
    rig = connect(PAPER, "rendered", None, 0, True)
    stale = Command(1, Twist(0.1, 0.0), 0.0, -1.0)
    wild = Command(2, Twist(float("nan"), 0.0), 0.0, 9.0)
    both = replace(rig, sink=Tee(rig.sink, NoRadio()))
    both.sink.send((stale, wild), 0.0)
    lines = account(replace(both, observers=(Behind(),)))
    assert lines[0] == "radio: 1 stale and 1 non-finite commands were not sent"
    assert lines[-1] == "Behind: 7 cycles were dropped because it was behind"
