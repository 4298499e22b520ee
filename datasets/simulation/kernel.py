"""A batch of whole runs in one call of machine code, as many at a time as there are cores."""

import numpy as np

from control.compilable import compilable
from datasets.simulation.filters import Filters, nothing_seen, roll_ahead, see
from datasets.simulation.inputs import (
    Chance,
    Field,
    Floats,
    Gains,
    Host,
    Trace,
    chance_of,
    trace_of,
)
from datasets.simulation.laws import Laws, follow_on, laws_at_rest, lead_on
from datasets.simulation.plants import Vehicle, drive_until, place
from datasets.simulation.restraint import restrain
from vision.compiled import compiled


@compiled
def run_batch(host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace) -> None:
    """Run N closed loops. A run's bits depend on its own row of `chance` alone.

    Args:
        host: what the host knows and wants.
        gains: the followers' laws and gains; `Field.gains` says whose is which.
        field: robots and references.
        chance: what happens to every run.
        trace: filled.
    """
    for run in range(len(chance.ticks)):
        _run(host, gains, field, chance_of(chance, run), trace_of(trace, run))


@compilable
def _run(host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace) -> None:
    """One run, tick by tick: the robots drive, the host sees, predicts and steers."""
    first, end, ticks = chance.ticks
    sent, rates = trace.commands, chance.rates.copy()
    vehicles = place(field.starts, field.plants, first)
    poses = np.empty_like(chance.noise)
    filters, laws, begins = nothing_seen(len(vehicles)), laws_at_rest(gains, field), True
    wishes, seen, rolled = np.empty((len(vehicles), 2)), np.nan, np.nan
    for tick in range(ticks):
        effect = tick * host.period + host.delay
        drive_until(vehicles, tick, host, chance, sent, poses)
        frame = chance.frame[tick]
        if frame >= 0:
            t = chance.stamp[frame]
            see(filters, host, field.pose_noise, poses[frame], seen, t, sent, (first, tick))
            seen = rolled = t
        roll_ahead(filters.ahead, filters.means, host, rolled, effect, sent, (first, tick))
        rolled = effect
        if first <= tick < end:
            _steer(laws, filters, host, field, chance, trace, tick, rates, begins, wishes)
            begins = chance.share[tick] <= 0.0
            rates[:] = 0.0  # measured before the start alone
        _note(trace, tick, vehicles, filters, tick * host.period)


@compilable
def _steer(
    laws: Laws, filters: Filters, host: Host, field: Field, chance: Chance, trace: Trace,
    tick: int, rates: Floats, begins: bool, wishes: Floats,
) -> None:  # fmt: skip
    """Commands of a tick; where all must stand, their laws begin anew."""
    share, mission = chance.share[tick], chance.mission[tick]
    commands = trace.commands[tick]
    if share <= 0.0:
        commands[:] = 0.0
        return
    wanted, ahead, means = field.wanted[mission], filters.ahead, filters.means
    lead_on(laws, ahead, means, host, field.planned[mission], begins, wishes)
    follow_on(laws, ahead, means, host, wanted, rates, begins, wishes)
    restrain(
        laws, ahead, means, host, field.freedoms, wanted, wishes, share, commands, trace.kept[tick]
    )


@compilable
def _note(trace: Trace, tick: int, vehicles: list[Vehicle], filters: Filters, t: float) -> None:
    """Keep what is true and what is believed."""
    for robot in range(len(vehicles)):
        motion = vehicles[robot].leg.at(t)
        for axis in range(5):
            trace.states[tick, robot, axis] = motion[axis]
            trace.ahead[tick, robot, axis] = filters.ahead[robot, axis]
