"""One channel as a regression: which terms its rows need beside the simulation."""
