"""Torque balances of the input and the load side, and the heat balance."""
