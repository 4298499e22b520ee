"""Finding robots beside what others use and beside the floors, on the same kind of pictures."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from benchmarks.methods import (
    Method,
    Setting,
    Shot,
    floors,
    in_turn,
    make_eye_for,
    own_methods,
    peer_methods,
    shots,
)
from benchmarks.scoring import Accuracy, Tally
from benchmarks.timing import Timed, interleaved
from vision.tags import TagSet

SETTINGS = (
    Setting((320, 240), 3, 300, 100),
    Setting((640, 480), 12, 100, 60),
    Setting((1920, 1080), 12, 30, 30),
    Setting((1920, 1080), 50, 30, 30, crowd=True),
)
FLOOR = 1  # the row that the others are compared with: packing and looking up
_KEPT = 8  # pictures that the times are taken on
_LONGEST_S = 8.0  # of the timing of one row


@dataclass(frozen=True, slots=True)
class Row:
    """One method at one size.

    Attributes:
        name: of the method.
        size: e.g. "320x240".
        robots: how many there are.
        time: what it takes; None if it could not be run.
        floor_ratio: processor time to that of packing the picture and looking its colours up.
        accuracy: what it finds; None for floors.
    """

    name: str
    size: str
    robots: int
    time: Timed | None
    floor_ratio: float | None
    accuracy: Accuracy | None


def measure(setting: Setting, with_peers: bool) -> list[Row]:
    """Measure all methods at one size, in turns.

    Args:
        setting: size and number of robots.
        with_peers: whether to measure what others use.

    Returns:
        Floors first.
    """
    eye = make_eye_for(setting)
    methods = own_methods(setting, eye) + (peer_methods(setting) if with_peers else [])
    found: dict[str, Accuracy] = {}
    some: dict[int, list[Shot]] = {}
    for tags in {id(method.tags): method.tags for method in methods}.values():
        same = [method for method in methods if method.tags is tags]
        some[id(tags)] = _scored(setting, tags, same, found)
    calls = floors(eye, some[id(setting.tags)])
    calls += [(m.name, in_turn(m.look, some[id(m.tags)])) for m in methods if m.look]
    _tell(setting, f"times of {len(calls)} calls in turns")
    names, timed = [name for name, _ in calls], [call for _, call in calls]
    times = dict(zip(names, interleaved(timed, setting.rounds, _LONGEST_S), strict=True))
    floor = times[names[FLOOR]].cpu_us
    names += [method.name for method in methods if not method.look]
    return [_row(setting, name, times.get(name), floor, found.get(name)) for name in names]


def _scored(
    setting: Setting, tags: TagSet, methods: Sequence[Method], found: dict[str, Accuracy]
) -> list[Shot]:
    """Score the methods on all pictures of some tags; keep a few pictures."""
    _tell(setting, f"{setting.frames} pictures for " + "; ".join(m.name for m in methods))
    tallies = {method.name: Tally() for method in methods if method.look}
    looks = [(method.look, tallies[method.name]) for method in methods if method.look]
    pictures = shots(setting, tags)
    kept: list[Shot] = []
    while some := list(islice(pictures, _KEPT)):
        kept = kept or some
        for look, tally in looks:
            for shot in some:
                tally.add(look(shot), shot.poses)
    found.update((name, tally.result()) for name, tally in tallies.items())
    return kept


def _row(
    setting: Setting, name: str, time: Timed | None, floor: float, found: Accuracy | None
) -> Row:
    size = "{}x{}".format(*setting.size_px)
    ratio = time.cpu_us / floor if time else None
    return Row(name, size, setting.robots, time, ratio, found)


def _tell(setting: Setting, what: str) -> None:
    size = "{}x{}".format(*setting.size_px)
    print(f"{size}, {setting.robots} robots: {what}", file=sys.stderr, flush=True)
