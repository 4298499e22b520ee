"""Worlds with known truth, the camera that renders them, and the files sessions are kept in."""
