"""The nominal simulation: polynomial Fourier series of the transmission error, and the file ``model.json``."""

from bench.simulation.fourier import FourierSet, TransmissionErrorModel, evaluate
from bench.simulation.model import NOMINAL_TERMS, Gearbox, Parameter, Simulation, Term
from bench.simulation.polynomial import TERM_COUNT, Standardisation, basis

__all__ = [
    "NOMINAL_TERMS",
    "TERM_COUNT",
    "FourierSet",
    "Gearbox",
    "Parameter",
    "Simulation",
    "Standardisation",
    "Term",
    "TransmissionErrorModel",
    "basis",
    "evaluate",
]
