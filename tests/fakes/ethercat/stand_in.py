"""Blocks for the in-process master, with a structured view for each slave."""

from __future__ import annotations

import numpy as np
import pysoem

from fakes.ethercat.master import EmulatedMaster
from tests.fakes.ethercat.simple_plant import simple_bench

INPUT, LOAD, TORQUE, TEMPERATURE = range(4)


class Bus:
    """A master in OP with buffers of ``rows`` cycles."""

    def __init__(self, rows: int = 100, bench=None) -> None:
        self.master = EmulatedMaster(bench or simple_bench())
        self.master.open("none")
        assert self.master.config_init() == len(self.master.bench.slaves)
        self.master.config_map()
        self.master.state = pysoem.OP_STATE
        self.master.write_state()
        assert self.master.state_check(pysoem.OP_STATE) == pysoem.OP_STATE
        slaves = self.master.bench.slaves
        self.raw_out = np.zeros((rows, sum(s.outputs.size for s in slaves)), np.uint8)
        self.raw_in = np.zeros((rows, sum(s.inputs.size for s in slaves)), np.uint8)
        self.wkc = np.zeros(rows, np.int32)
        self.out = self._views(self.raw_out, [s.outputs for s in slaves])
        self.in_ = self._views(self.raw_in, [s.inputs for s in slaves])
        self.out[INPUT]["6060:00"], self.out[LOAD]["6060:00"] = 9, 10

    def _views(self, block, layouts):
        views, at = [], 0
        for layout in layouts:
            views.append(np.ndarray((len(block),), layout.dtype, block, at, (block.strides[0],)))
            at += layout.size
        return views

    def run(self, rows: int | None = None) -> np.ndarray:
        n = len(self.wkc) if rows is None else rows
        assert self.master.exchange_block(self.raw_out[:n], self.raw_in[:n], self.wkc[:n]) == n
        return self.wkc[:n]

    def set(self, control: int, **setpoints: int) -> None:
        for view in self.out[:2]:
            view["6040:00"] = control
        for name, value in setpoints.items():
            for view in self.out[:2]:
                view[name[1:5] + ":00"] = value

    def enable(self) -> None:
        for control in (0x06, 0x07, 0x0F):
            self.set(control)
            self.run(4)
        assert self.in_[INPUT]["6041:00"][3] & 0x6F == 0x27
        assert self.in_[LOAD]["6041:00"][3] & 0x6F == 0x27
