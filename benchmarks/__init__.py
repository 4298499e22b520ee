"""What is timed, each against its floor, in one run and one table: `make bench`."""
