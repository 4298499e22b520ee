"""Tags on paper: where they go, and the PDF."""
