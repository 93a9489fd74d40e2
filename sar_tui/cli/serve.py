"""``sar-tui serve``: the operator's panel, an observer's view, or the agent alone, in a browser."""

import signal
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.session_choice import Link
from sar_tui.drivers import child_process

_UNENCRYPTED = (
    "Others can reach this, and read along: it is not encrypted. Use an SSH tunnel instead of --host, or a proxy "
    "with TLS and --public-url."
)


def serve(
    context: typer.Context,
    view: Annotated[
        Literal["operator", "observer", "agent"],
        typer.Argument(help="The operator's panel, the same to look at only, or the agent alone.", show_default=False),
    ],
    session: Annotated[
        str | None,
        typer.Option("--session", metavar="SESSION", show_default=False, help="Which, where there are several."),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(metavar="NAME", show_default=False, help="What an operator is called there; else the login name."),
    ] = None,
    link: Link = None,
    host: Annotated[str, typer.Option(metavar="HOST", help="Where to listen; as it is, for this machine alone.")] = (
        "127.0.0.1"
    ),
    port: Annotated[int, typer.Option(min=0, max=65535, metavar="N", help="0 takes any that is free.")] = 8000,
    public_url: Annotated[
        str,
        typer.Option(metavar="URL", show_default=False, help="What browsers open, behind a tunnel or a proxy."),
    ] = "",
    token_file: Annotated[
        Path | None,
        typer.Option(metavar="FILE", show_default=False, help="Keep the token here; else it is new each time."),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show a session in a browser, while the task stays in its terminal.

    Prints the address to open, with the token that it needs, and serves until Ctrl-C.
    """
    from sar_tui.cli.wizard import name_there
    from sar_tui.link.errors import need_packages
    from sar_tui.runs.plan import Failed

    home = Home.of(context, data, tasks)
    if link is not None and not link.is_file():
        raise Refused(f"There is no file {link}; an invitation is made by `sar-tui link invite`.")
    if link is not None and session is not None:
        raise Refused("An invitation is to one session: leave out --session.")
    if name is not None:
        if view != "operator":
            raise Refused("Only an operator has a name of their own: leave out --name.")
        name_there(name, link, observe=False)
    need_packages()
    try:
        from sar_tui.serve import address, runner, server, token
    except ImportError as error:
        raise Refused(
            f"Serving to a browser needs the package {error.name}: pip install 'sar-tui[serve]' brings it."
        ) from error
    try:
        secret = token.load_or_create_token(token_file) if token_file else token.new_token()
        address.Address(host, port, public_url)
        taken = runner.listen(host, port)
    except (token.TokenError, address.AddressError) as error:
        raise Refused(str(error)) from error
    except runner.ListenError as error:
        raise Failed(str(error)) from error
    place = address.Address(host, taken.getsockname()[1], public_url)
    if not place.is_loopback:
        print(_UNENCRYPTED, file=sys.stderr)
    url = f"{place.url}?token={secret}"

    def ready() -> None:
        """One line, for whoever opens it; programs are told the parts, too."""
        if as_json:
            print_json({"view": view, "url": url, "host": host, "port": place.port, "token": secret})
        else:
            print(url)
        sys.stdout.flush()

    served = server.Server(view, _program(view, session, link, home, name), place, secret)
    number = runner.run(served, taken, ready)
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise typer.Exit(128 + number)


def _program(view: str, session: str | None, link: Path | None, home: Home, name: str | None = None) -> list[str]:
    """The command that each browser is shown: words of a list, which no shell reads."""
    command = {"operator": ["wizard"], "observer": ["wizard", "--observe"], "agent": ["agent"]}[view]
    program = [*child_process.python("sar_tui"), *command, "--data", str(home.folder.absolute())]
    for folder in home.tasks:
        program += ["--tasks", str(folder.absolute())]
    if link is not None:
        program += ["--link", str(link.absolute())]
    if name is not None:
        program += ["--name", name]
    return program if session is None else [*program, "--", session]
