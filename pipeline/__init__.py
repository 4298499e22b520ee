"""The clock, the devices and the commands: everything that touches the world outside."""
