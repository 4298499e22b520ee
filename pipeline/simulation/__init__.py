"""`echelon simulate`: a scenario as tables, what chance decides, many runs, their figures."""
