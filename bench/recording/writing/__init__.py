"""A recording while it is made: its layout, the order of what goes to the disk, the thread that owns the file."""
