"""`echelon cameras`: what can be opened, with formats and controls."""

from pipeline.cli import options


def cameras(json: options.Json = False) -> None:
    """List the cameras at this machine: formats, rates, controls, and the SPEC for live --camera.

    Network cameras (http, rtsp, udp) and files are named by their address and cannot be listed.
    """
    from pipeline.cli.listing import list_cameras
    from pipeline.cli.output import Output

    list_cameras(Output(json))
