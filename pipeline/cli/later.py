"""Commands of the contract that are not built yet: they say so, with exit status 2."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

import typer

from pipeline.errors import ConfigError

LATER = {
    "cameras": "what can be opened; until then: echelon live --camera SPEC says what is wrong",
}


def register(app: typer.Typer, commands: Mapping[str, str] = MappingProxyType(LATER)) -> None:
    """Add commands to a command line.

    Args:
        app: the command line, or a group of it.
        commands: name and what it will do.
    """
    for name, what in commands.items():
        _register_one(app, name, what)


def _register_one(app: typer.Typer, name: str, what: str) -> None:
    settings = {"allow_extra_args": True, "ignore_unknown_options": True}

    def _not_yet(arguments: Annotated[list[str] | None, typer.Argument()] = None) -> None:
        del arguments
        raise ConfigError(f"{name}: not in this version ({what})")

    text = f"Not in this version: {what}."
    app.command(name, help=text, short_help="Not in this version.", context_settings=settings)(
        _not_yet
    )
