"""The heat balance and the temperature sensor: shows in temperature.

The regressors of this channel are integrals over time: T(t) − T(0) is what the balance of heat has brought in since the
recording began, so the balance is linear in 1/C, 1/(R·C) and T_amb/(R·C) without differentiating a temperature.
"""
