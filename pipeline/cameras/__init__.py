"""Frame sources: one adapter a file, all of the shape `pipeline.ports.FrameSource`."""
