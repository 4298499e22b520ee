"""What is timed, each against its peers and its floor, in one run and one table: `make bench`."""

import os

# One thread for all. Read when numpy is loaded, so it must be said before anything else.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
