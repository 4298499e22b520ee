"""Telling other programs what is seen: one observer a file."""
