"""Hours of simulated driving with random faults: which promises of docs/safety.md hold."""
