"""The rules of the recording format: each yields what is wrong and what would be right."""
