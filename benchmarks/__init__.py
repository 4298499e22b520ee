"""What is timed, each against its peers and its floor, in one run and one table: `make bench`."""

import os

# One thread for all but batches of simulated runs, which numba spreads over the cores. Read when
# numpy is loaded, so it must be said before anything else.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
