"""Learning what the eye needs from pictures: colours, camera."""
