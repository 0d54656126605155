"""Runs of the service: the queue, who holds the controls, the process of the present run, and how it is stopped."""
