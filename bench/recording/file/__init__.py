"""An HDF5 file as it stands on the disk: attributes, names, claims, where samples lie, whose file it is."""
