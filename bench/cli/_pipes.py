"""Output that nobody reads any more: ``bench … | head`` ends as the command ends, and a campaign is run to its end."""

from __future__ import annotations

import io
import os
import stat
import sys
from typing import TYPE_CHECKING, TextIO, TypeGuard

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class _PipeThatMayClose(io.FileIO):
    """A pipe into nothing once its reader has gone; whoever writes need not know."""

    def write(self, data: ReadableBuffer, /) -> int:
        """Write what is taken; all of it counts as written where nobody reads any more. Gives the number of bytes."""
        try:
            return super().write(data)
        except BrokenPipeError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return super().write(data)


def let_pipes_close() -> None:
    """Have standard output and standard error go nowhere, without an error, when they are pipes without a reader."""
    if sys.stdout is sys.__stdout__ and _is_pipe(sys.stdout):
        sys.stdout = _that_may_close(sys.stdout)
    if sys.stderr is sys.__stderr__ and _is_pipe(sys.stderr):
        sys.stderr = _that_may_close(sys.stderr)


def _is_pipe(stream: TextIO | None) -> TypeGuard[TextIO]:
    if stream is None or stream.closed:
        return False
    mode = os.fstat(stream.fileno()).st_mode
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


def _that_may_close(stream: TextIO) -> TextIO:
    """The same stream, with the same encoding and buffering."""
    stream.flush()
    raw = _PipeThatMayClose(stream.fileno(), "wb", closefd=False)
    line_buffering = isinstance(stream, io.TextIOWrapper) and stream.line_buffering
    write_through = isinstance(stream, io.TextIOWrapper) and stream.write_through
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=line_buffering,
        write_through=write_through,
    )
