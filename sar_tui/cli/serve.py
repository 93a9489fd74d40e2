"""``sar-tui serve``: shows the operator's panel, an observer's view, or the agent alone in a
browser.
"""

import signal
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from sar_tui.cli.common import AsJson, Home, Protocol, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.wizard import Link, name_at_session, read_protocol, session_to_show
from sar_tui.drivers import child_process
from sar_tui.drivers.installation import pip_install_extra

_UNENCRYPTED = (
    "Others on the network can reach this and read along: it is not encrypted. Use an SSH tunnel "
    "instead of --host, "
    "or a proxy with TLS and --public-url."
)


def serve(
    home: Home,
    view: Annotated[
        Literal["operator", "observer", "agent"],
        typer.Argument(
            help="The operator's panel, the same read-only, or the agent alone.", show_default=False
        ),
    ],
    session: Annotated[
        str | None,
        typer.Option(
            "--session",
            metavar="SESSION",
            show_default=False,
            help="The session, if several are running.",
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", show_default=False, help="The operator's name. Default: the login name."
        ),
    ] = None,
    link: Link = None,
    protocol: Protocol = None,
    host: Annotated[
        str, typer.Option(metavar="HOST", help="Address to listen on. Default: this machine only.")
    ] = ("127.0.0.1"),
    port: Annotated[
        int,
        typer.Option(min=0, max=65535, metavar="N", help="Port to listen on; 0 picks a free one."),
    ] = 8000,
    public_url: Annotated[
        str,
        typer.Option(
            metavar="URL",
            show_default=False,
            help="URL that browsers open, behind a tunnel or proxy.",
        ),
    ] = "",
    token_file: Annotated[
        Path | None,
        typer.Option(
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="File that stores the token. Default: a new token each time.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show a session in a browser, while the task stays in its terminal.

    Prints the address to open, including the token, and serves until Ctrl-C.
    """
    from sar_tui.link.errors import need_packages
    from sar_tui.runs.plan import Failed

    if link is not None and not link.is_file():
        why = f"{link} is not a file." if link.exists() else f"There is no file {link}."
        raise Refused(f"{why} Create an invitation with `sar-tui link invite`.")
    if link is not None and session is not None:
        raise Refused("An invitation is for one session: leave out --session.")
    _check_operator(view, link, name, protocol)
    need_packages()
    if link is not None or session is not None:  # refused here rather than in every browser
        session_to_show(session, link, home.folder, wait=False, observe=view == "observer")
    try:
        from sar_tui.serve import address, runner, server
        from sar_tui.serve import guard as token
    except ImportError as error:
        raise Refused(
            f"Serving to a browser needs the package {error.name}. Install it with: "
            f"{pip_install_extra('serve')}"
        ) from error
    try:
        secret = token.load_or_create_token(token_file) if token_file else token.new_token()
        address.Address(host, port, public_url)
        listening = runner.listen(host, port)
    except (token.TokenError, address.AddressError) as error:
        raise Refused(str(error)) from error
    except runner.ListenError as error:
        raise Failed(str(error)) from error
    place = address.Address(host, listening.getsockname()[1], public_url)
    if not place.is_loopback:
        print(_UNENCRYPTED, file=sys.stderr)
    url = f"{place.url}?token={secret}"

    def print_address() -> None:
        """Print one line, with --json including the parts of the address."""
        if as_json:
            print_json(
                {"view": view, "url": url, "host": host, "port": place.port, "token": secret}
            )
        else:
            print(url)
        sys.stdout.flush()

    from sar_tui.tui.exit_codes import after_signal

    program = _program(view, session, link, home, name, protocol)
    served = server.Server(
        view,
        program,
        place,
        secret,
        is_ready=lambda: link is not None or _is_live(session, home.folder),
    )
    number = runner.run(served, listening, print_address)
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise typer.Exit(after_signal(number))


def _check_operator(view: str, link: Path | None, name: str | None, protocol: Path | None) -> None:
    """Refuse a name and a protocol that are wrong, or of somebody who is no operator."""
    if name is not None:
        if view != "operator":
            raise Refused("Only an operator has a name: leave out --name.")
        name_at_session(name, link, observe=False)
    if protocol is not None:
        if view != "operator":
            raise Refused("Only an operator works by a protocol: leave out --protocol.")
        read_protocol(protocol)


def _is_live(session: str | None, data: Path) -> bool:
    """Return True if a session of a data folder can be joined now."""
    from sar_tui.link.discovery import joinable_sessions
    from sar_tui.link.errors import LinkError

    try:
        return any(each.session.startswith(session or "") for each in joinable_sessions(data))
    except LinkError:
        return False


def _program(
    view: str,
    session: str | None,
    link: Path | None,
    home: Home,
    name: str | None = None,
    protocol: Path | None = None,
) -> list[str]:
    """Return the command that runs in each browser, as a list."""
    command = {"operator": ["wizard"], "observer": ["wizard", "--observe"], "agent": ["agent"]}[
        view
    ]
    program = child_process.python("sar_tui", *command, "--data", str(home.folder.absolute()))
    for folder in home.tasks:
        program += ["--tasks", str(folder.absolute())]
    if link is not None:
        program += ["--link", str(link.absolute())]
    if name is not None:
        program += ["--name", name]
    if protocol is not None:
        program += ["--protocol", str(protocol.absolute())]
    return program if session is None else [*program, "--", session]
