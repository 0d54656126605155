"""Recordings from elsewhere, through a small mapping file that says which variable is which channel."""

from bench.importing.importer import Imported, import_recordings
from bench.importing.mapping import Mapping, load_mapping

__all__ = ["Imported", "Mapping", "import_recordings", "load_mapping"]
