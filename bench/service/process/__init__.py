"""The process of one run: it alone opens the bus; the web process is at the other end of a Unix socket."""
