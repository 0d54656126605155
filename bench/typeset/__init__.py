"""How reports are set: equations in MathML, values in the units people use."""

from bench.typeset.mathml import mathml, names_of, symbol
from bench.typeset.units import engineering, figure, plain

__all__ = ["engineering", "figure", "mathml", "names_of", "plain", "symbol"]
