"""What a machine offers for a bench in real time, and what to change."""
