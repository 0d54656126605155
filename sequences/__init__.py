"""What a campaign does: one sequence a file; imports only bench.protocols."""
