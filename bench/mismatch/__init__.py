"""What physics a simulation leaves out."""
