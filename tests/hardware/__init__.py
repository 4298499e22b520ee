"""Emulated hardware at the far end of real sockets and ptys."""
