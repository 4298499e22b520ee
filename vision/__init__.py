"""Vision: a frame in, robot poses out. No capture, no file, no clock."""
