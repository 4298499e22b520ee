"""Calibration: boards, pictures and points come in, fragments and pictures go out."""
