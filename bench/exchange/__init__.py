"""Export: what a simulation predicts of recordings, and simulations for other people's tools."""
