"""What `echelon calibrate colors` does: frames in, a palette out, and what to think of it."""

from pathlib import Path
from typing import Any

from datasets.recorded import IMAGE_SUFFIXES, is_session, read_session
from pipeline.cli.output import Output
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.glimpses import glimpse
from pipeline.palette_file import LIGHT, palette_text, rival_lines, write_palette
from pipeline.readiness import ready_to_look
from pipeline.scenario import load_scenario, parse_scenario, scenario_names
from pipeline.seeing import colored_eye, named_colors
from pipeline.viewers.classes import draw_classes
from pipeline.viewers.overlay import draw_scene, write_picture
from vision.calibration.colors import LearnedColors, learn_colors
from vision.calibration.learned import palette_from_samples
from vision.calibration.lessons import Collected
from vision.errors import VisionError
from vision.eye import Eye, make_eye
from vision.frame import Frame
from vision.locate import locate
from vision.palette import NamedColor


def calibrate_colors(
    arguments: list[str], out: Path, count: int, overrides: tuple[str, ...], output: Output
) -> None:
    """Learn the palette from a few frames and write it down.

    Args:
        arguments: sources, and perhaps a scenario after them.
        out: the TOML fragment; before and after pictures are put beside it.
        count: at most so many frames of a folder, video, session or camera.
        overrides: changes to the scenario.
        output: where to say it.

    Raises:
        ConfigError: if the scenario is wrong, or the frames do not show what is needed.
        RecordingError: if a file cannot be read.
        CameraError: if the camera fails.
    """
    sources, scenario = _parted(arguments, overrides)
    frames = glimpse(sources, count)
    before = colored_eye(ready_to_look(scenario), frames[0].size_px)
    colors = named_colors(scenario)
    try:
        learned = learn_colors(tuple(frame.image for frame in frames), before, colors)
    except VisionError as error:
        raise ConfigError(f"{', '.join(sources)}: {error}") from None
    names = [_name(frame) for frame in frames]
    write_palette(out, palette_text(learned, before.tags, scenario.name, names))
    after = _with_palette(before, learned)
    first = _picture(frames[0], before, out, "before", colors)
    then = _picture(frames[0], after, out, "after", colors)
    _tell(learned, after, (first, then), out, output)


def _with_palette(before: Eye, learned: LearnedColors) -> Eye:
    """The same eye with the colours just learned."""
    samples = tuple(collected.samples for collected in learned.colors)
    palette = palette_from_samples(samples, learned.prints, LIGHT)
    return make_eye(
        before.camera, before.tags, palette, before.optics, before.thresholds, before.field_px
    )


def _picture(frame: Frame, eye: Eye, out: Path, when: str, colors: tuple[NamedColor, ...]) -> int:
    """Draw classes and robots as an eye sees them; the number of robots."""
    scene = locate(frame, eye)
    picture = draw_classes(frame.image, eye.palette, colors)
    path = out.with_name(f"{out.stem}_{when}.png")
    write_picture(path, draw_scene(picture, scene, eye.tags, eye.camera))
    return len(scene.detections)


def _parted(arguments: list[str], overrides: tuple[str, ...]) -> tuple[tuple[str, ...], Scenario]:
    """Sources and scenario; a session brings its own."""
    last = arguments[-1]
    if len(arguments) > 1 and (last.endswith(".toml") or last in scenario_names()):
        return tuple(arguments[:-1]), load_scenario(last, overrides)
    if last.endswith(".toml"):
        raise ConfigError(f"{last}: is a scenario; say before it what shows the scene")
    if is_session(last) and not overrides:
        return tuple(arguments), parse_scenario(read_session(Path(last)).header.scenario)
    return tuple(arguments), load_scenario("paper", overrides)


def _name(frame: Frame) -> str:
    """An image by its file, any other frame by its source and number."""
    single = Path(frame.camera_id).suffix.lower() in IMAGE_SUFFIXES
    return frame.camera_id if single else f"{frame.camera_id} {frame.sequence}"


def _tell(
    learned: LearnedColors, eye: Eye, seen: tuple[int, int], out: Path, output: Output
) -> None:
    if output.as_json:
        output.object(_as_json(learned, eye, seen, out))
        return
    rows = [_row(collected, learned) for collected in learned.colors]
    header = ("colour", "pixels", "mean r g b", "nearest", "error up to %", "verdict")
    output.table(f"{len(learned.lessons)} tags taught", header, rows)
    for line in _remarks(learned):
        output.say(line)
    output.say(f"robots found in the first frame: before {seen[0]}, after {seen[1]}")
    output.say(f'{out}: include it in a scenario: include = ["{out.name}"]')
    output.say(f"pictures: {out.stem}_before.png, {out.stem}_after.png beside it")


def _row(collected: Collected, learned: LearnedColors) -> tuple[str, ...]:
    """A colour and its nearest rival, as text."""
    name = collected.samples.name
    rgb = " ".join(f"{value:.0f}" for value in collected.samples.pixels.mean(axis=0)[::-1])
    rival = next((r for r in learned.rivals if name in (r.one, r.other)), None)
    if rival is None:
        return name, str(collected.count), rgb, "-", "-", "-"
    other = rival.other if rival.one == name else rival.one
    return name, str(collected.count), rgb, other, f"{100.0 * rival.error:.2f}", rival.verdict


def _remarks(learned: LearnedColors) -> list[str]:
    """What to know before trusting the palette."""
    lines = rival_lines(learned.rivals)
    if learned.missing:
        robots = ", ".join(map(str, learned.missing))
        lines.append(f"robots not found in any frame: {robots}; their colours come from others")
    if learned.unsure:
        lines.append(f"{learned.unsure} tags were found, but too doubtful to teach")
    return lines


def _as_json(learned: LearnedColors, eye: Eye, seen: tuple[int, int], out: Path) -> dict[str, Any]:
    rivals = [
        {"one": r.one, "other": r.other, "error": r.error, "verdict": r.verdict,
         "confused": [list(pair) for pair in r.confused]}
        for r in learned.rivals
    ]  # fmt: skip
    colors = [
        {"name": c.samples.name, "pixels": c.count,
         "mean_bgr": c.samples.pixels.mean(axis=0).tolist()}
        for c in learned.colors
    ]  # fmt: skip
    taught = [
        {"frame": lesson.frame, "id": eye.tags.ids[lesson.tag], "margin": lesson.margin}
        for lesson in learned.lessons
    ]
    return {
        "file": str(out), "colors": colors, "rivals": rivals, "taught": taught,
        "unsure": learned.unsure, "missing": list(learned.missing),
        "margin": learned.margin if learned.margin < float("inf") else None,
        "found_before": seen[0], "found_after": seen[1],
    }  # fmt: skip
