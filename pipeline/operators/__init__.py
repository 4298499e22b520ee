"""People at the controls: one adapter a file, all of the shape `pipeline.ports.Operator`."""
