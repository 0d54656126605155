"""Estimates and their uncertainties where recordings, not samples, are the unit of evidence."""
