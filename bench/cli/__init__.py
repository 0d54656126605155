"""Command line of the bench."""

from bench.cli.app import main

__all__ = ["main"]
