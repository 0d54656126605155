"""EtherCAT slaves of the emulated bench, served in process (``master``) or on a network interface (``wire``)."""
