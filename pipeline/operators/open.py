"""Who is at the controls of a run: signals always, and keys where there is a terminal."""

from collections.abc import Callable

from pipeline.errors import ConfigError
from pipeline.operators.keys import HELP, HELP_DRIVING
from pipeline.operators.terminal import Terminal, there_is_a_terminal
from pipeline.operators.together import Together
from pipeline.ports import Operator
from pipeline.setup import Setup


def open_operator(setup: Setup, signals: Operator, say: Callable[[str], None]) -> Operator:
    """Take the controls.

    Args:
        setup: says whether keys drive the leader.
        signals: who sends signals.
        say: tells the person which keys there are.

    Returns:
        The operator.

    Raises:
        ConfigError: if keys are to drive the leader and there is no terminal.
    """
    if not there_is_a_terminal():
        if setup.keys:
            raise ConfigError(
                f'scenario {setup.name}: leader.driven_by = "keys" needs a terminal; this '
                "program's input or its messages go elsewhere"
            )
        return signals
    say(f"keys: {HELP_DRIVING if setup.keys else HELP}; Ctrl-C ends")
    if setup.rules.hold:
        say("nothing moves before r is pressed")
    return Together((signals, Terminal(setup.keys)))
