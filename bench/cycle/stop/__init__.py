"""A stop on the bench: what each rung of the ladder sends, how the shafts coast down, the record that is kept."""
