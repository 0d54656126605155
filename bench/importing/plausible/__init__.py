"""Whether what was imported can be: signs and scales that physics rules out, with the likely right one."""

from bench.importing.plausible.checks import implausible, misspelt
from bench.importing.plausible.torques import gain_note

__all__ = ["gain_note", "implausible", "misspelt"]
