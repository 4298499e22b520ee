"""A batch of whole runs in one call of machine code, as many at a time as there are cores."""

import numpy as np

from control.compilable import compilable
from datasets.simulation.filters import Filters, nothing_seen, roll_ahead, see
from datasets.simulation.inputs import Chance, Field, Floats, Gains, Host, Trace
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
        _run(host, gains, field, chance, trace, run)


@compilable
def _run(host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace, run: int) -> None:
    """One run, tick by tick: the robots drive, the host sees, predicts and steers."""
    first, end, ticks = chance.ticks[run]
    sent, rates = trace.commands[run], chance.rates[run].copy()
    vehicles = place(field.starts, field.plants, first)
    poses = np.empty((chance.taken.shape[1], len(vehicles), 3))
    filters, laws, begins = nothing_seen(len(vehicles)), laws_at_rest(gains, field), True
    wishes, seen, rolled = np.empty((len(vehicles), 2)), np.nan, np.nan
    for tick in range(ticks):
        effect = tick * host.period + host.delay
        _drive(vehicles, host, chance, run, tick, sent, poses)
        frame = chance.frame[run, tick]
        if frame >= 0:
            measured, t = poses[frame] + chance.noise[run, frame], chance.stamp[run, frame]
            see(filters, host, field.pose_noise, measured, seen, t, sent, (first, tick))
            seen = rolled = t
        roll_ahead(filters.ahead, filters.means, host, rolled, effect, sent, (first, tick))
        rolled = effect
        if first <= tick < end:
            _steer(laws, filters, host, field, chance, trace, run, tick, rates, begins, wishes)
            begins = chance.share[run, tick] <= 0.0
            rates[:] = 0.0  # measured before the start alone
        _note(trace.states[run, tick], vehicles, tick * host.period)
        trace.ahead[run, tick] = filters.ahead


@compilable
def _drive(
    vehicles: list[Vehicle], host: Host, chance: Chance, run: int, tick: int, sent: Floats,
    poses: Floats,
) -> None:  # fmt: skip
    """All robots drive until a tick."""
    lost, taken, tones = chance.lost[run], chance.taken[run], chance.tones[run]
    for robot in range(len(vehicles)):
        vehicles[robot] = drive_until(
            vehicles[robot], robot, tick, host.period, host.delay, sent, lost, taken, poses, tones
        )


@compilable
def _steer(
    laws: Laws, filters: Filters, host: Host, field: Field, chance: Chance, trace: Trace,
    run: int, tick: int, rates: Floats, begins: bool, wishes: Floats,
) -> None:  # fmt: skip
    """Commands of a tick; where all must stand, their laws begin anew."""
    share, mission = chance.share[run, tick], chance.mission[run, tick]
    commands = trace.commands[run, tick]
    if share <= 0.0:
        commands[:] = 0.0
        return
    wanted, ahead, means = field.wanted[mission], filters.ahead, filters.means
    lead_on(laws, ahead, means, host, field.planned[mission], begins, wishes)
    follow_on(laws, ahead, means, host, wanted, rates, begins, wishes)
    restrain(
        laws, ahead, means, host, field.freedoms, wanted, wishes, share, commands,
        trace.kept[run, tick],
    )  # fmt: skip


@compilable
def _note(states: Floats, vehicles: list[Vehicle], t: float) -> None:
    """Keep what is true, as (R, 5)."""
    for robot in range(len(vehicles)):
        motion = vehicles[robot].leg.at(t)
        for index in range(5):
            states[robot, index] = motion[index]
