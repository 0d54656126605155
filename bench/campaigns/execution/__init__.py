"""The run of a campaign: point after point, waits, the quality gate, what becomes of each."""
