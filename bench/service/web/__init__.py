"""The HTTP side of the service: routes, who may talk to it, and how long it waits for a request."""
