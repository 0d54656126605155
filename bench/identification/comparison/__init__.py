"""Two models compared, what such a comparison finds, and how often intervals hold the truth."""
