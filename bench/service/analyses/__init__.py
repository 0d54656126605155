"""Analyses at low priority: identification, mismatch reports, investigations, and the twin of the present run."""
