"""The slaves of the bench: servo drive, input terminals, safety terminal, and what they have in common."""
