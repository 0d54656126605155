"""Campaigns that may be started: the catalog, plans, and campaigns that the laboratory saved."""
