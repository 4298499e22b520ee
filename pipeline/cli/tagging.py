"""What `echelon tags` does: a layout or a scenario in, a PDF out."""

import sys
from pathlib import Path

from datasets.errors import RecordingError
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.layouts import layout_names, make_tags, nominal_colors, shipped_layout
from pipeline.scenario import check_tables, load_scenario, scenario_names
from pipeline.sheets.arrange import PrintedTag, arrange, paper_named
from pipeline.sheets.pdf import Sheet, sheet_pdf
from vision.errors import VisionError


def print_tags(what: str, overrides: tuple[str, ...], paper: str, out: Path) -> None:
    """Write the sheet of a layout or a scenario.

    Args:
        what: name of a shipped layout or scenario, or a scenario file.
        overrides: "section.key=value" texts.
        paper: "a4" or "letter".
        out: the PDF.

    Raises:
        ConfigError: if there is no such layout or scenario, its tags are inconsistent or too large.
        RecordingError: if the file cannot be written.
    """
    if out.suffix.lower() != ".pdf":
        raise ConfigError(f"--out {out}: need a name that ends with .pdf")
    sheet = make_sheet(tags_scenario(what, overrides), paper)
    try:
        out.write_bytes(sheet_pdf(sheet))
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error})") from None
    tags, pages = sum(len(page) for page in sheet.pages), len(sheet.pages)
    text = f"{tags} tags on {pages} page{'s' * (pages > 1)}: {out}"
    print(text, file=sys.stderr)  # noqa: T201 (what was asked for)


def tags_scenario(what: str, overrides: tuple[str, ...] = ()) -> Scenario:
    """The scenario whose tags are to be printed.

    Args:
        what: name of a shipped layout, of which every pattern is worn by one robot, or of a
            scenario, or a scenario file.
        overrides: "section.key=value" texts.

    Returns:
        The scenario.

    Raises:
        ConfigError: if there is no such layout or scenario, or it is wrong.
    """
    if what in layout_names():
        patterns = shipped_layout(what).patterns
        numbers = [int(name) if name.isdecimal() else name for name in patterns]
        robots = [{"id": number, "pattern": number} for number in numbers]
        return check_tables(
            {"name": what, "tags": {"layout": what}, "robots": robots}, f"layout {what}", overrides
        )
    path = Path(what)
    if path.suffix != ".toml" and not path.is_file() and what not in scenario_names():
        raise ConfigError(
            f'no tag layout or scenario "{what}"; layouts: {", ".join(layout_names())}; '
            f"scenarios: {', '.join(scenario_names())}"
        )
    return load_scenario(what, overrides)


def make_sheet(scenario: Scenario, paper: str) -> Sheet:
    """Lay out the sheet of a scenario's tags.

    Args:
        scenario: with tags and robots.
        paper: "a4" or "letter".

    Returns:
        The sheet.

    Raises:
        ConfigError: if the tags are inconsistent or larger than the paper.
    """
    try:
        tags = make_tags(scenario)
    except VisionError as error:
        raise ConfigError(f"scenario {scenario.name}: {error}") from None
    nominal = nominal_colors(scenario) | (
        {} if "black" in scenario.colors else {"black": "#000000"}
    )
    colors = tuple((name, nominal[name]) for name in tags.colors)
    layout, size = scenario.tags.layout, paper_named(paper)
    printed = tuple(PrintedTag(tag, f"{layout}, id {tag.robot_id}") for tag in tags.tags)
    title = f"{scenario.name}: tags {layout}" if scenario.name != layout else f"tags {layout}"
    return Sheet(title, size, arrange(printed, size, len(colors)), colors)
