"""The emulated slaves on a network interface: EtherCAT frames parsed and answered at register level."""
