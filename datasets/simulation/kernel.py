"""A batch of whole runs in one call of machine code, as many at a time as there are cores."""

import numpy as np
from numba import prange

from control.compilable import compilable
from datasets.simulation.filters import Filters, nothing_seen, roll_ahead, see
from datasets.simulation.inputs import Chance, Field, Gains, Host, Trace
from datasets.simulation.laws import laws_at_rest, steer
from datasets.simulation.plants import Plants, drive_until, place
from datasets.simulation.restraint import restrain
from vision.compiled import compiled_side_by_side


@compiled_side_by_side
def run_batch(host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace) -> None:
    """Run N closed loops. A run's bits depend on its own row of `chance` alone.

    Args:
        host: what the host knows and wants.
        gains: the followers' laws and gains; `Field.gains` says whose is which.
        field: robots and references.
        chance: what happens to every run.
        trace: filled.
    """
    for run in prange(len(chance.ticks)):
        _run(host, gains, field, chance, trace, run)


@compilable
def _run(
    host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace, run: int
) -> None:
    """One run, tick by tick: the robots drive, the host sees, predicts and steers."""
    count, first = len(field.starts), chance.ticks[run, 0]
    sent, rates = trace.commands[run], chance.rates[run]
    plants = place(field, chance.tones[run], chance.lost[run], chance.taken[run], first)
    filters, laws = nothing_seen(count), laws_at_rest(gains, field.gains)
    for tick in range(chance.ticks[run, 2]):
        drive_until(plants, field, host.period, host.delay, sent, tick)
        frame = chance.frame[run, tick]
        if frame >= 0:
            measured = plants.poses[frame] + chance.noise[run, frame]
            see(filters, host, field, measured, chance.stamp[run, frame], sent, (first, tick))
        roll_ahead(filters, host, tick * host.period + host.delay, sent, (first, tick))
        if first <= tick < chance.ticks[run, 1]:
            share, mission = chance.share[run, tick], chance.mission[run, tick]
            if share > 0.0:
                steer(laws, filters, host, field, mission, rates, sent[tick])
                restrain(laws, filters, host, field, share, sent[tick], trace.kept[run, tick])
            else:  # all stand, and their laws begin anew
                sent[tick], laws.begun[:] = 0.0, False
            rates = np.zeros_like(rates)  # it was measured before the start alone
        _note(trace, run, tick, tick * host.period, plants, filters)


@compilable
def _note(
    trace: Trace, run: int, tick: int, t: float, plants: Plants, filters: Filters
) -> None:
    """Keep what is true and what is believed at a tick."""
    for robot in range(len(plants.legs)):
        state, ahead = trace.states[run, tick, robot], trace.ahead[run, tick, robot]
        motion = plants.legs[robot].at(t)
        for index in range(5):
            state[index] = motion[index]
        b = filters.ahead[robot]
        ahead[0], ahead[1], ahead[2], ahead[3], ahead[4] = b.x, b.y, b.theta, b.v, b.omega
