"""Pseudo-terminals that stand for serial cables."""

from __future__ import annotations

import os
import select
import threading
import tty


class Cable:
    """Two pseudo-terminals joined: what is written to ``near`` is read from ``far`` and the other way round.

    Both ends are device names that any program opens as a serial port. A thread of its own passes the bytes on.
    """

    def __init__(self) -> None:
        pairs = [os.openpty(), os.openpty()]
        for _, device in pairs:
            tty.setraw(device)
        self._sides = [side for side, _ in pairs]
        self._devices = [device for _, device in pairs]
        self.near, self.far = (os.ttyname(device) for device in self._devices)
        self._wake_read, self._wake_write = os.pipe()
        self._plugged = True
        self._thread = threading.Thread(target=self._pump, name="serial cable", daemon=True)
        self._thread.start()

    def unplug(self, unplugged: bool = True) -> None:
        """Drop (or pass again) everything that is sent."""
        self._plugged = not unplugged

    def close(self) -> None:
        """Take the cable away; both ends hang up."""
        os.write(self._wake_write, b"x")
        self._thread.join()
        for descriptor in (*self._sides, *self._devices, self._wake_read, self._wake_write):
            os.close(descriptor)

    def _pump(self) -> None:
        one, other = self._sides
        across = {one: other, other: one}
        while True:
            ready, _, _ = select.select([*self._sides, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            for side in ready:
                data = os.read(side, 4096)
                if self._plugged:
                    os.write(across[side], data)
