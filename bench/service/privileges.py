"""The web process gives away what it does not need: no capability stays, and no program it starts can get one back."""

from __future__ import annotations

import ctypes
import os
import sys

_PR_SET_NO_NEW_PRIVS = 38
_PR_CAP_AMBIENT = 47
_PR_CAP_AMBIENT_CLEAR_ALL = 4
_VERSION_3 = 0x20080522
"""Of the capget/capset interface (linux/capability.h): two words of 32 capabilities each."""


class _Header(ctypes.Structure):
    _fields_ = (("version", ctypes.c_uint32), ("pid", ctypes.c_int))


class _Data(ctypes.Structure):
    _fields_ = (("effective", ctypes.c_uint32), ("permitted", ctypes.c_uint32), ("inheritable", ctypes.c_uint32))


def drop() -> None:
    """Give away all capabilities of the calling thread; call it before others are started.

    Raises
    ------
    OSError
        If the kernel refuses, which it does for nobody who gives something away.
    """
    if sys.platform != "linux":
        # there is no bus to open there either: the emulated bench needs no privilege
        return
    libc = ctypes.CDLL(None, use_errno=True)
    _check_result(libc.prctl(_PR_CAP_AMBIENT, _PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0))
    nothing = (_Data * 2)()
    _check_result(libc.capset(ctypes.byref(_Header(_VERSION_3, 0)), ctypes.byref(nothing)))
    _check_result(libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))


def _check_result(result: int) -> None:
    if result != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
