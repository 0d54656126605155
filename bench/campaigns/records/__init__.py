"""What a run leaves behind: recordings, the journal, the manifest, records of stops."""
