"""The `echelon` command: one small file a sub-command."""
