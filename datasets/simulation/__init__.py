"""Whole runs as machine code: robots, a camera that tells poses, and the host that steers."""
