"""What a campaign does: each sequence turns a point into phases of motion, from rest to rest."""
