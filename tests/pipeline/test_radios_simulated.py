"""The simulated link: delay, loss and bandwidth, to the message; and SPECs of radios."""

import pytest

from control.command import Command
from control.unicycle import Twist, UnicycleState
from datasets.world import RobotPlant, World
from pipeline.clock import MonotonicClock
from pipeline.radios.budget import Budget
from pipeline.radios.none import NoRadio
from pipeline.radios.open import RadioSettings, open_radio
from pipeline.radios.simulated import MESSAGE_SIZE, Copies, SimulatedRadio

CLOCK = MonotonicClock()


def world_of(*ids: int) -> World:
    """Robots at rest whose motors obey at once."""
    rest = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
    return World(tuple(RobotPlant(robot_id, rest, lag=0.0) for robot_id in ids))


def drive(v: float, now: float, robot_id: int = 1, valid: float = 0.1) -> tuple[Command, ...]:
    return (Command(robot_id, Twist(v, 0.0), now, now + valid),)


def speed(world: World) -> float:
    return world.truth()[0].state.v


def test_a_command_takes_effect_after_the_delay_and_not_before() -> None:
    world = world_of(1)
    radio = SimulatedRadio(world, delay=0.02)
    assert radio.send(drive(0.3, 0.0), 0.0) == ()
    world.advance(0.0199)
    assert speed(world) == 0.0
    world.advance(0.0201)
    assert speed(world) == pytest.approx(0.3)
    world.advance(1.0)
    assert world.truth()[0].state.x == pytest.approx(0.3 * 0.98)  # m


def test_losses_are_of_the_declared_share_and_repeatable() -> None:
    counts = []
    for _ in range(2):
        radio = SimulatedRadio(world_of(1), loss=0.2, seed=7)
        for n in range(5000):
            radio.send(drive(0.1, n * 0.005), n * 0.005)
        counts.append(radio.lost)
    assert counts[0] == counts[1]
    assert counts[0] / 5000 == pytest.approx(0.2, abs=0.02)  # 3.5 standard deviations
    assert radio.sent == 5000


def test_a_narrow_link_carries_what_it_can_and_the_newest_wins() -> None:
    world = world_of(1)
    radio = SimulatedRadio(world, delay=0.0, bandwidth_Bps=240.0)  # a message in 50 ms
    assert radio.min_period == pytest.approx(0.05)
    speeds = []
    for n in range(100):
        now = n * 0.005
        world.advance(now)
        speeds.append(round(1000 * speed(world)))
        radio.send(drive(0.001 * n, now), now)
    assert radio.sent == 10
    assert radio.sent + radio.replaced in (99, 100)
    assert sorted(set(speeds)) == speeds[1::10]
    assert all(n - sent <= 11 for n, sent in enumerate(speeds))  # never older than a message


def test_stale_and_non_finite_commands_are_counted_and_stay_here() -> None:
    world = world_of(1)
    radio = SimulatedRadio(world, delay=0.0)
    radio.send(drive(0.1, 0.0, valid=-0.001), 0.0)
    radio.send(drive(float("nan"), 0.0), 0.0)
    radio.send(drive(float("inf"), 0.0), 0.0)
    world.advance(0.1)
    assert speed(world) == 0.0
    assert (radio.screen.stale, radio.screen.refused, radio.sent) == (1, 2, 0)


def test_what_waits_for_a_narrow_link_may_go_stale_there() -> None:
    radio = SimulatedRadio(world_of(1), bandwidth_Bps=MESSAGE_SIZE / 0.5)
    radio.send(drive(0.1, 0.0), 0.0)
    radio.send(drive(0.2, 0.01), 0.01)
    radio.send((), 0.51)
    assert (radio.sent, radio.screen.stale) == (1, 1)


def test_stop_reaches_everyone_although_a_command_waits() -> None:
    world = world_of(1, 2)
    radio = SimulatedRadio(world, delay=0.005, bandwidth_Bps=240.0)
    radio.send((*drive(0.3, 0.0, 1), *drive(0.4, 0.0, 2)), 0.0)
    radio.send((*drive(0.5, 0.01, 1), *drive(0.5, 0.01, 2)), 0.01)
    world.advance(0.02)
    radio.stop(0.02)
    radio.send((), 1.0)
    world.advance(1.0)
    assert [robot.state.v for robot in world.truth()] == [0.0, 0.0]
    assert radio.sent == 2 + 3 * 2
    radio.close()
    radio.close()


def test_budget_spaces_messages_without_bursts() -> None:
    budget = Budget(1150.0)
    assert budget.wait(10.0) == 0.0
    budget.spend(12, 10.0)
    assert budget.wait(10.0) == pytest.approx(12 / 1150)
    assert budget.wait(10.1) == 0.0
    budget.spend(12, 20.0)
    budget.spend(12, 20.0)
    assert budget.wait(20.0) == pytest.approx(24 / 1150)
    assert 1.0 / budget.min_period(12) == pytest.approx(95.8, abs=0.1)  # 100 commands/s are over


def test_no_radio_shows_and_sends_nothing() -> None:
    radio = open_radio("none", CLOCK, RadioSettings())
    assert isinstance(radio, NoRadio)
    assert radio.send(drive(0.1, 0.0) + drive(float("nan"), 0.0), 0.0) == ()
    assert (radio.shown, radio.screen.refused) == (1, 1)
    radio.stop(0.0)
    radio.close()


def test_copies_are_of_the_declared_share_repeatable_and_leave_losses_as_they_are() -> None:
    told = []
    for copies in (Copies(0.0), Copies(0.3, 0.02), Copies(0.3, 0.02)):
        world = world_of(1)
        radio = SimulatedRadio(world, loss=0.2, seed=7, copies=copies)
        for n in range(5000):
            world.advance(n * 0.005)
            radio.send(drive(0.001 * (n % 100), n * 0.005), n * 0.005)
        told.append((radio.lost, radio.doubled, world.truth()[0].state.x))
    assert told[1] == told[2]
    assert told[0][0] == told[1][0]
    assert told[0][1] == 0
    assert told[1][1] / (5000 - told[1][0]) == pytest.approx(0.3, abs=0.025)  # 3.5 deviations
    assert told[0][2] != told[1][2]  # a late copy of an old command is obeyed


def test_a_copy_arrives_behind_a_newer_command() -> None:
    world = world_of(1)
    radio = SimulatedRadio(world, delay=0.0, seed=3, copies=Copies(0.999, 0.05))
    radio.send(drive(0.1, 0.0), 0.0)
    radio.send(drive(0.5, 0.001), 0.001)
    world.advance(0.0015)
    assert speed(world) == pytest.approx(0.5)
    seen = set()
    for n in range(60):
        world.advance(0.0015 + n * 0.001)
        seen.add(round(speed(world), 3))
    assert 0.1 in seen
    assert radio.reports[0].counts.doubled == 2


def test_every_robot_has_its_own_counts() -> None:
    world = world_of(1, 2)
    radio = SimulatedRadio(world, bandwidth_Bps=240.0)
    for n in range(10):
        radio.send(drive(0.1, n * 0.01, 2), n * 0.01)
    one, two = radio.reports
    assert (one.robot_id, one.counts.sent, two.robot_id) == (1, 0, 2)
    assert two.counts.sent + two.counts.replaced in (9, 10)
    assert two.counts.rate == two.counts.sent
