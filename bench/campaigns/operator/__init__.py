"""What an operator does at a bench: directions to a run, notes, motion by hand, the reset after a stop."""
