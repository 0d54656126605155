"""What identification takes from the samples of a recording: windows, blocks, and sums over the angle."""
