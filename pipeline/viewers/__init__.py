"""Viewers: observers that show a run while it happens."""
