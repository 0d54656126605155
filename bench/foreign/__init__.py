"""Simulations that are not ours: channels predicted elsewhere, Python functions, FMUs; what they say of a recording."""
