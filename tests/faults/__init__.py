"""Runs in which everything goes wrong at random times, and the promises are watched."""
