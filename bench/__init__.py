"""The test bench service: what the bench is, does, records and knows."""

__version__ = "0.1.0"
