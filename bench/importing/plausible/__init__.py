"""Whether what was imported can be: signs and scales that physics rules out, with the likely right one."""

from bench.importing.plausible.checks import implausible, misspelt

__all__ = ["implausible", "misspelt"]
