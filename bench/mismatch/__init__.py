"""Mismatch analysis: noise floor, location, hypotheses, selection, report, next experiment. Sees recordings only."""

from bench.mismatch.run import Report, run

__all__ = ["Report", "run"]
