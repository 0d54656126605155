"""What a campaign is and what it will cost: its definition, its files, its plan on a bench."""
