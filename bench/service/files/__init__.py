"""The service's files: the record book, what outlasts a restart, and the thread that writes them."""
