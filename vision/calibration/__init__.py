"""Learning a camera and its colours from pictures."""
