"""Recordings from elsewhere, through a small mapping file that says which variable is which channel."""

from bench.recording.importing.importer import Imported, import_recordings
from bench.recording.importing.mapping import Mapping, load_mapping

__all__ = ["Imported", "Mapping", "import_recordings", "load_mapping"]
