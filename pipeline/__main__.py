"""`python -m pipeline` is the command `echelon`."""

from pipeline.cli.start import main

main()
