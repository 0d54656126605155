"""Recordings that others made and published: what the analyser says of them beside what an expert finds by hand."""
