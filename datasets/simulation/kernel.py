"""A batch of whole runs in one call of machine code, as many at a time as there are cores."""

import numpy as np

from control.compilable import compilable
from datasets.simulation.filters import nothing_seen, roll_ahead, see
from datasets.simulation.inputs import Chance, Field, Floats, Gains, Host, Trace
from datasets.simulation.laws import follow_on, laws_at_rest, lead_on
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
    period, delay, sent = host.period, host.delay, trace.commands[run]
    lost, taken, tones = chance.lost[run], chance.taken[run], chance.tones[run]
    vehicles = place(field.starts, field.plants, first)
    rates = chance.rates[run].copy()
    poses, seen, rolled = np.empty((len(taken), len(vehicles), 3)), np.nan, np.nan
    filters, laws, begins = nothing_seen(len(vehicles)), laws_at_rest(gains, field), True
    means, ahead, wishes = filters.means, filters.ahead, np.empty((len(vehicles), 2))
    for tick in range(ticks):
        for robot in range(len(vehicles)):
            vehicles[robot] = drive_until(
                vehicles[robot], robot, tick, period, delay, sent, lost, taken, poses, tones
            )
        frame = chance.frame[run, tick]
        if frame >= 0:
            measured, t = poses[frame] + chance.noise[run, frame], chance.stamp[run, frame]
            see(filters, host, field.pose_noise, measured, seen, t, sent, (first, tick))
            seen = rolled = t
        effect = tick * period + delay
        roll_ahead(ahead, means, host, rolled, effect, sent, (first, tick))
        rolled = effect
        if first <= tick < end:
            share, commands = chance.share[run, tick], sent[tick]
            mission = chance.mission[run, tick]
            if share > 0.0:
                wanted = field.wanted[mission]
                lead_on(laws, ahead, means, host, field.planned[mission], begins, wishes)
                follow_on(laws, ahead, means, host, wanted, rates, begins, wishes)
                restrain(
                    laws, ahead, means, host, field.freedoms, wanted, wishes, share, commands,
                    trace.kept[run, tick],
                )  # fmt: skip
            else:  # all stand, and their laws begin anew
                commands[:] = 0.0
            begins = share <= 0.0
            rates[:] = 0.0  # measured before the start alone
        _note(trace.states[run, tick], vehicles, tick * period)
        trace.ahead[run, tick] = ahead


@compilable
def _note(states: Floats, vehicles: list[Vehicle], t: float) -> None:
    """Keep what is true, as (R, 5)."""
    for robot in range(len(vehicles)):
        motion = vehicles[robot].leg.at(t)
        for index in range(5):
            states[robot, index] = motion[index]
