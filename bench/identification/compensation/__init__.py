"""The model in use: as C source, and as feedforward of a motion."""
