"""What each kind of radio can carry, beside what a scenario's command period asks of it."""

from collections.abc import Iterator

from control.command import RobotId
from pipeline.config import Scenario
from pipeline.finding import Finding
from pipeline.radio_config import RadioConfig, radio_settings
from pipeline.radios.miabot_text import LONGEST_COMMAND
from pipeline.radios.simulated import MESSAGE_SIZE
from pipeline.radios.vsss import BYTES_PER_SECOND, vsss_channel

TYPICAL = len(b"[=-500,-500]")  # of a Miabot's commands [B]


def check_radios(scenario: Scenario, robots: tuple[RobotId, ...]) -> Iterator[Finding]:
    """Say for every kind of radio how often it carries a command for every robot.

    Args:
        scenario: command period and `[radio]`.
        robots: who is commanded.

    Yields:
        One finding per kind; none fails: what is too fast for a link goes out as often as it can.
    """
    r, period = scenario.radio, scenario.control.command_period_s
    rate = r.link_bytes_per_s
    need = f"{TYPICAL / period:.0f} B/s of {rate:g} B/s a link" + _slower(
        LONGEST_COMMAND / rate, period
    )
    yield Finding("radio budget, miabot and miabot-tcp", True, _every(period, need))
    yield _vsss(r, robots, period)
    detail = "one datagram for all robots, no budget; nobody stops its robots if this program dies"
    yield Finding("radio budget, firasim", True, _every(period, detail))
    if r.bandwidth_bytes_per_s is not None:
        need = f"{MESSAGE_SIZE / period:.0f} B/s of {r.bandwidth_bytes_per_s:g} B/s a link"
        need += _slower(MESSAGE_SIZE / r.bandwidth_bytes_per_s, period)
        yield Finding("radio budget, simulated", True, _every(period, need))


def _vsss(r: RadioConfig, robots: tuple[RobotId, ...], period: float) -> Finding:
    settings = radio_settings(r)
    longest = vsss_channel("", robots, settings.wheels, settings.vsss).longest
    detail = (
        f"{longest / period:.0f} B/s of {BYTES_PER_SECOND:g} B/s (messages of up to {longest} B, "
        f"wheel speeds in {r.vsss_unit} with {r.vsss_decimals} decimals)"
    )
    detail += _slower(longest / BYTES_PER_SECOND, period)
    return Finding("radio budget, vsss", True, _every(period, detail))


def _every(period: float, detail: str) -> str:
    return f"a command every {1e3 * period:g} ms: {detail}"


def _slower(shortest: float, period: float) -> str:
    if shortest <= period:
        return ""
    return f"; too fast: such a link carries one every {1e3 * shortest:.1f} ms, the newest wins"
