"""The transmission error as a series over the angle: orders, and polynomials of amplitudes and phases, two ways."""
