"""ONE cycle: a tick in, commands out. Pure: the same memory and tick give the same bits.

Read this file first. Each stage is a verb in a room of its own: `tracking` looks, corrects at the
capture time and predicts; `obedience` watches who does what it is told; `guard` says who may move,
`route` whether the leader's way is clear, `supervisor` whether the formation may move; `steering`
runs the laws; `restraint` keeps bodies apart. Live runs and replays turn the same crank.
"""

from control.command import Command
from datasets.cycle import Cycle, RobotState, Tick
from pipeline.guard import watch_over
from pipeline.identity import doubted, doubts_told
from pipeline.memory import Laws, Memory
from pipeline.obedience import disobedient, watch_obedience
from pipeline.restraint import restrain
from pipeline.route import renew, wanted_motion
from pipeline.setup import Setup
from pipeline.steering import STANDSTILL, Aim, commands_of, relate, steer
from pipeline.supervisor import DRIVING, supervise
from pipeline.tracking import Locate, ahead_of, find_robots, look, remember, without_nonsense
from pipeline.watching import forget_glimpses, initial_rates, watch

NO_COMMANDS: tuple[Command, ...] = ()
NO_NOTES: tuple[str, ...] = ()


def step(
    setup: Setup, memory: Memory, tick: Tick, locate: Locate = find_robots
) -> tuple[Memory, Cycle]:
    """One cycle: frame -> poses -> predicted relative states -> sliding-mode laws -> commands.

    Args:
        setup: all that is constant in a run.
        memory: what the last cycle left.
        tick: the inputs: the moment, a new frame or none, links that are down.
        locate: the vision; the live loop passes one that takes the time.

    Returns:
        The memory for the next cycle, and the record of this one.
    """
    dt = setup.period if memory.t is None else tick.t - memory.t
    tick = without_nonsense(tick, memory.frame)
    scene, tracks = look(setup, memory.tracks, memory.light, tick, locate)  # at capture time
    t_effective = tick.t + setup.radio_delay
    tracks = ahead_of(setup, tracks, t_effective)  # through the commands already sent
    seen = {robot: track.estimate.t for robot, track in tracks.items()}
    obedience = watch_obedience(setup, memory.obedience, tracks, scene, tick)
    standing = dict((*doubted(setup.rules, tracks), *disobedient(setup.rules, obedience, tick.t)))
    guard, shares, events = watch_over(
        setup.rules, memory.guard, setup.formation, seen, tick, standing
    )
    mission = watch(setup, memory.mission, scene)
    route, shares, met, news = renew(setup, memory.route, mission, tracks, shares, tick)
    mission, shares, ordered = supervise(setup, mission, tracks, shares, tick, dt)
    events = (*events, *met, *ordered)

    t_mission = t_effective - (tick.t if mission.t_start is None else mission.t_start)
    pairs = relate(setup, tracks, t_mission)
    planned = wanted_motion(setup, route, t_mission)

    laws, commands, notes = Laws(), NO_COMMANDS, NO_NOTES
    if mission.phase in DRIVING and mission.t_start is not None:
        rates, notes = initial_rates(setup, mission)
        aim = Aim(planned, tick.orders.drive or STANDSTILL, pairs, shares, rates)
        laws, twists = steer(setup, memory.laws, aim, tracks, dt)
        laws, twists, close = restrain(setup, laws, twists, aim, tracks, tick.t, dt)
        events = (*events, *close)
        commands = commands_of(setup, twists, tick.t, t_effective)
        tracks, mission = remember(tracks, commands), forget_glimpses(mission)
    robots = tuple(RobotState(robot, track.ahead) for robot, track in tracks.items())
    cycle = Cycle(
        tick.t, t_effective, mission.phase, mission.t_start, scene, robots, pairs,
        planned if mission.t_start is not None else None, commands, events,
        (*doubts_told(setup.tags, memory.tracks, tracks, tick.t), *news, *notes),
    )  # fmt: skip
    light, frame = (memory.light, memory.frame) if scene is None else (scene.light, tick.frame)
    return Memory(tick.t, tracks, obedience, guard, mission, route, laws, light, frame), cycle
