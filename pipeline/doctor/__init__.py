"""What of a machine can spoil a run, and what to do about it; one small check each."""
