import os
import socket
import time
from collections.abc import Iterator

import pytest

from drivers.ethercat.nonblocking import FrameWait, drain, packet_sockets, set_nonblocking


@pytest.fixture
def raw_socket() -> Iterator[socket.socket]:
    try:
        made = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
    except (PermissionError, AttributeError, OSError) as error:
        pytest.skip(f"raw sockets cannot be opened here: {error}")
    with made:
        yield made


def test_finds_the_packet_socket_that_was_opened_in_between(raw_socket: socket.socket) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        found = packet_sockets()
        assert raw_socket.fileno() in found
        assert other.fileno() not in found
        assert set_nonblocking(frozenset({raw_socket.fileno()})) == 1
        assert not os.get_blocking(raw_socket.fileno())
        assert os.get_blocking(other.fileno())


def test_looking_does_not_close_anything() -> None:
    left, right = socket.socketpair()
    with left, right:
        packet_sockets()
        left.sendall(b"x")
        assert right.recv(1) == b"x"


def test_wait_ends_with_a_frame_or_with_patience() -> None:
    left, right = socket.socketpair()
    with left, right:
        wait = FrameWait(right.fileno(), patience_us=2000)
        start = time.monotonic()
        assert not wait()
        assert time.monotonic() - start >= 0.0019
        left.sendall(b"frame")
        assert wait()
        assert wait()  # it looks, it does not read


def test_all_that_came_is_dropped_where_no_cycle_waits_and_an_interface_that_has_gone_is_no_error() -> None:
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with near, far:
        near.setblocking(False)
        for number in range(200):
            far.send(bytes([number]))
        drain(near.fileno())
        with pytest.raises(BlockingIOError):
            near.recv(16)
        gone = near.fileno()
    drain(gone)  # closed: it is polled as invalid


def test_frames_that_came_too_late_are_dropped() -> None:
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with near, far:
        near.setblocking(False)
        wait = FrameWait(near.fileno(), 1000)
        wait.drain()
        for number in range(8):
            far.send(bytes([number]))
        wait.drain()
        assert not wait()
        far.send(b"new")
        assert wait()
        assert near.recv(16) == b"new"
