"""The object dictionary of a slave: objects, data types, access rules, process data, identity."""
