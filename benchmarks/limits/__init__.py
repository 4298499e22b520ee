"""How far the vision carries: noise x blur x size, and every effect: `python -m benchmarks.limits`."""
