"""The emulated bench: plant, slaves, devices, faults and concealed effects."""
