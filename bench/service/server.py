"""``bench serve`` itself: one service a bus; privileges given away; the web server; its end at a signal."""

from __future__ import annotations

import errno
import socket
import sys
from types import FrameType

from bench.configuration import load_bench, on_interface
from bench.errors import ConfigurationError
from bench.locks import folder_in_use, serving
from bench.safety.runtime import socket_path
from bench.service.privileges import drop
from bench.service.runs.launcher import Launcher
from bench.service.runs.run_process import SOCKET
from bench.service.runs.runs import new_id
from bench.service.settings import Settings


def run(settings: Settings) -> None:
    """Serve until SIGINT or SIGTERM; a run goes on in its own process.

    Raises
    ------
    DeviceError
        If another service has this bus or this folder, or the runtime folder is of no use.
    ConfigurationError
        If the bench file or the address is wrong, or the port in use.
    """
    _look(settings)
    # a run could not listen to anybody where the path of its socket is too long
    socket_path(f"{new_id()}{SOCKET}")
    file = load_bench(settings.bench)
    if settings.interface is not None:
        file = on_interface(file, settings.interface)
    address = {"url": settings.url, "token": settings.token, "folder": str(settings.folder.absolute())}
    if settings.certificate is not None:
        address["certificate"] = str(settings.certificate.absolute())
    with serving(file, address), folder_in_use(settings.state, address), _listening(settings) as listening:
        # first the launcher, which keeps the privileges, then away with them, then everything that talks to the world
        launcher = Launcher()
        drop()
        _serve(settings, launcher, listening)


def _look(settings: Settings) -> None:
    """Refuse files and folders that are not there, before anything begins."""
    for option, path in (
        ("--campaigns", settings.campaigns),
        ("--model", settings.model),
        ("--tls-certificate", settings.certificate),
        ("--tls-key", settings.key),
    ):
        if path is None:
            continue
        if not (path.is_dir() if option == "--campaigns" else path.is_file()):
            raise ConfigurationError(
                f"{option} {path}: there is no such {'folder' if option == '--campaigns' else 'file'}"
            )


def _listening(settings: Settings) -> socket.socket:
    """Take the port before anything else is said or begun."""
    try:
        family, *_, place = socket.getaddrinfo(settings.host, settings.port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(place, family=family)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            why = f"another program has port {settings.port}; give another with --port"
        else:
            why = f"{error.strerror}; look at --host and --port"
        raise ConfigurationError(f"{settings.url} cannot be served: {why}") from error


def _serve(settings: Settings, launcher: Launcher, listening: socket.socket) -> None:
    import uvicorn

    from bench.service.web.app import create_app
    from bench.service.web.patient import PatientProtocol, allow_descriptors

    allow_descriptors()

    # into a terminal only: what a service manager keeps may be read by others
    secret = settings.token is not None and sys.stdout.isatty()
    shown = settings.url + (f"/#token={settings.token}" if secret else "/")
    sys.stdout.write(
        f"The page is at {shown}\nRecordings go to {settings.folder.absolute()}. Ctrl-C ends the service.\n"
    )
    sys.stdout.flush()
    app = create_app(settings, launcher)

    class Server(uvicorn.Server):
        def handle_exit(self, sig: int, frame: FrameType | None) -> None:
            # pages hold their stream of events open; without this the server would wait for them
            app.state.service.stream.close()
            super().handle_exit(sig, frame)

    config = uvicorn.Config(
        app,
        log_level="warning",
        ssl_certfile=settings.certificate,
        ssl_keyfile=settings.key,
        server_header=False,
        http=PatientProtocol,
        ws="none",
        timeout_graceful_shutdown=3,
    )
    Server(config).run(sockets=[listening])
    running = app.state.service.keeper.runs.running()
    if running is not None:
        sys.stdout.write(f"A run goes on in process {running.pid}; start bench serve again to watch or stop it.\n")
