"""Questions about the laws, each answered by one figure and one table."""
