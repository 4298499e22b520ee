"""From the option --publish to an observer that publishes."""

from pipeline.errors import ConfigError
from pipeline.ports import Observer
from pipeline.publishers.ssl_vision import MULTICAST, SslVision


def open_publisher(spec: str, yellow: bool) -> Observer:
    """Open what a SPEC names.

    Args:
        spec: `ssl-vision` or `ssl-vision:HOST:PORT`.
        yellow: whether the robots are the yellow team's.

    Returns:
        The observer.

    Raises:
        ConfigError: if the SPEC names nothing that is known, or no address.
    """
    kind, colon, place = spec.partition(":")
    if kind != "ssl-vision" or (colon and not place):
        raise ConfigError(f"--publish {spec}: need ssl-vision or ssl-vision:HOST:PORT")
    return SslVision(place or MULTICAST, yellow)
