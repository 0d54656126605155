"""What is in a file that nobody described yet, and a mapping to begin with."""

from bench.importing.looking.ask import ask
from bench.importing.looking.column import Column
from bench.importing.looking.draft import draft
from bench.importing.looking.entries import Draft, write_new
from bench.importing.looking.inventory import Inventory, take_inventory

__all__ = ["Column", "Draft", "Inventory", "ask", "draft", "take_inventory", "write_new"]
