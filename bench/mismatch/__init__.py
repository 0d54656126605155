"""When simulation and recordings differ: locate it, name the physics left out, model it, show the fit improve."""
