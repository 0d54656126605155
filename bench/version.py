"""The version of this software and where it lies, for whatever writes it down."""

from pathlib import Path

__version__ = "0.1.0"
PACKAGE = Path(__file__).resolve().parent
"""Folder of the package ``bench``."""
