"""Whether the bench that asks comes to the right name, and in how many hours of bench time."""
