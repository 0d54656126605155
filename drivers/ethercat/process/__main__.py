"""Entry of the bus process: ``python -m drivers.ethercat.process PIPE MEMORY``, two inherited file descriptors."""

import sys

from drivers.ethercat.process.server import serve

serve(int(sys.argv[1]), int(sys.argv[2]))
