"""Figures and the HTML page of a session, for people who read."""
