"""Files of other tools as tables of named variables; what a file is, is found from its content."""

from bench.importing.formats.opening import open_source
from bench.importing.formats.source import Source, Variable

__all__ = ["Source", "Variable", "open_source"]
