"""What `echelon calibrate colors` does."""
