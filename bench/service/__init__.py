"""``bench serve``: one run at a time in a process of its own, a queue, an HTTP API, live events, the operator's page.

The web process never opens the bus. A run lives in :mod:`bench.service.process`, sends what happens over a Unix
socket and goes on when nobody listens.
"""
