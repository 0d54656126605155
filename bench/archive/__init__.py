"""Finding recordings again: an index in SQLite over folders of recordings, made of nothing but what stands in them."""

from bench.archive.facts import RESULTS, Facts
from bench.archive.index import Found, Index
from bench.archive.notes import KINDS, Note, add_note, read_notes
from bench.archive.query import Query

__all__ = ["KINDS", "RESULTS", "Facts", "Found", "Index", "Note", "Query", "add_note", "read_notes"]
