"""`echelon doctor`: whether this machine is fit for a run, and what to do where it is not."""

import typer

from pipeline.cli import options


def doctor(json: options.Json = False) -> None:
    """Check the machine: software, permissions, processor, beat, buffers, disk, buses, viewer.

    Exit status 2 if something is bad: the set-up is wrong, no device has failed. Warnings do not
    change it.
    """
    from pipeline.cli.output import Output
    from pipeline.cli.start import foreign_packages
    from pipeline.doctor.examine import examine

    findings = tuple(examine(foreign_packages()))
    Output(json).diagnosis(findings)
    raise typer.Exit(2 if any(f.verdict == "bad" for f in findings) else 0)
