"""Alarms: what they say, when they end, and who is notified."""
