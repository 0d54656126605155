"""What makes a slave a CiA 402 servo drive: states, power stage, objects, scaling, error codes."""
