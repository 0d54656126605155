"""What is periodic in the angle: the simulation's series, orders it lacks, what these orders are signs of."""
