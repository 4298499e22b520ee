"""Who finds other ways: one adapter a file, all of the shape `pipeline.ports.Planner`."""
