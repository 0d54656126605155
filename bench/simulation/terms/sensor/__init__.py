"""Errors of the sensors."""
