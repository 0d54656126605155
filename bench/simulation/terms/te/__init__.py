"""The transmission error: the slow part (offset) and the part periodic in the angle."""
