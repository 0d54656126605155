"""The cycle: set values in, process images out, under the safety step."""
