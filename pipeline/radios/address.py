"""HOST:PORT, as options write it."""

from pipeline.errors import ConfigError

HIGHEST = 65535


def parse_address(text: str, what: str = "radio") -> tuple[str, int]:
    """Read HOST:PORT; a host with colons stands in brackets, [::1]:9000.

    Args:
        text: the address.
        what: it belongs to, for the error.

    Returns:
        Host and port, 1 to 65535.

    Raises:
        ConfigError: if it is no such address.
    """
    host, _, port = text.strip().rpartition(":")
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        host = ""
    number = int(port) if port.isascii() and port.isdecimal() and len(port) < 6 else 0
    if not host or not 1 <= number <= HIGHEST:
        raise ConfigError(f"{what} {text!r}: need HOST:PORT with a port from 1 to {HIGHEST}")
    return host, number
