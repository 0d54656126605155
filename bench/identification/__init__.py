"""Identification: from recordings to the paper's model, reproduced, and a better one beside it."""

from bench.identification.identify import Identification, Options, identify_folder, with_proposed_orders
from bench.identification.summary import to_json, to_simulation

__all__ = ["Identification", "Options", "identify_folder", "to_json", "to_simulation", "with_proposed_orders"]
