"""A batch of whole runs in one call of machine code, as many at a time as there are cores."""

import numpy as np
from numba import prange

from control.compilable import compilable
from control.unicycle import UnicycleState
from datasets.simulation.filters import nothing_seen, roll_ahead, see
from datasets.simulation.inputs import Chance, Field, Floats, Gains, Host, Trace
from datasets.simulation.laws import laws_at_rest, steer
from datasets.simulation.plants import Leg, drive_until, place
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
def _run(host: Host, gains: Gains, field: Field, chance: Chance, trace: Trace, run: int) -> None:
    """One run, tick by tick: the robots drive, the host sees, predicts and steers."""
    first, end, ticks = chance.ticks[run]
    period, delay, sent, rates = host.period, host.delay, trace.commands[run], chance.rates[run]
    lost, taken, tones = chance.lost[run], chance.taken[run], chance.tones[run]
    plants = place(field.starts, field.plants, len(taken), first)
    filters, laws = nothing_seen(len(field.starts)), laws_at_rest(gains, field.gains)
    for tick in range(ticks):
        drive_until(plants, tick, period, delay, sent, lost, taken, tones)
        frame = chance.frame[run, tick]
        if frame >= 0:
            measured, t = plants.poses[frame] + chance.noise[run, frame], chance.stamp[run, frame]
            see(filters, host, field.pose_noise, measured, t, sent, (first, tick))
        roll_ahead(filters, host, tick * period + delay, sent, (first, tick))
        if first <= tick < end:
            share, mission = chance.share[run, tick], chance.mission[run, tick]
            if share > 0.0:
                steer(laws, filters, host, field, mission, rates, sent[tick])
                restrain(
                    laws, filters, host, field, mission, share, sent[tick], trace.kept[run, tick]
                )
            else:  # all stand, and their laws begin anew
                sent[tick], laws.begun[0] = 0.0, False
            rates = np.zeros_like(rates)  # it was measured before the start alone
        _note(
            trace.states[run, tick],
            trace.ahead[run, tick],
            plants.legs,
            filters.ahead,
            tick * period,
        )


@compilable
def _note(
    states: Floats, ahead: Floats, legs: list[Leg], believed: list[UnicycleState], t: float
) -> None:
    """Keep what is true, and what is believed, as (R, 5)."""
    for robot in range(len(legs)):
        motion, b = legs[robot].at(t), believed[robot]
        for index in range(5):
            states[robot, index] = motion[index]
        ahead[robot, 0], ahead[robot, 1], ahead[robot, 2] = b.x, b.y, b.theta
        ahead[robot, 3], ahead[robot, 4] = b.v, b.omega
