"""Command sinks: one adapter a file, all of the shape `pipeline.ports.CommandSink`."""
