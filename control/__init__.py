"""Formation control: geometry, motion, sliding modes, estimation. Pure functions and values."""
