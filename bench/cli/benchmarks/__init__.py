"""``bench benchmark …``: a command each; see :mod:`bench.cli.benchmark`."""
