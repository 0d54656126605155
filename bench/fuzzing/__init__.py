"""Files spoiled at random, and whether what reads them refuses, crashes, hangs, or believes what is wrong."""

from bench.fuzzing.run import KINDS, Tally, fuzz

__all__ = ["KINDS", "Tally", "fuzz"]
