"""From a folder of recordings to rows that can be compared."""
