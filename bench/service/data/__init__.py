"""Recordings for the page: folders, plots, downloads, and the archive."""
