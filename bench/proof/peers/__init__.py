"""What one would otherwise pick: sparse and symbolic regression on the same residuals, with a library as good as ours.

Each peer gets the calibrated simulation's residual of each channel and, where it takes one, a library of candidate
columns for the whole vocabulary, orthogonalised against the simulation's own parameters, with orders screened by
spectrum beforehand and the selection pruned backward over held-out recordings: what a careful user would do.
"""

from bench.proof.peers.compare import Compared, compare_peers

__all__ = ["Compared", "compare_peers"]
