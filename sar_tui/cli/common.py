"""Options and helpers that the commands share."""

import inspect
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    import sqlite3

    from rich.console import Console

    from sar_tui.loop.task import Task
    from sar_tui.model.step import Step
    from sar_tui.plugins import Catalogue


def named_path(text: str) -> Path:
    """Return a path that was given to an option. An empty one, as of a variable that is not set, is
    bad usage.
    """
    if not text:
        raise typer.BadParameter("a name is missing: it is empty.")
    return Path(text)


Data = Annotated[
    Path | None,
    typer.Option(
        "--data",
        parser=named_path,
        metavar="DIR",
        show_default=False,
        help="The data folder. Default: SAR_TUI_DATA, or the user's data folder.",
    ),
]
Tasks = Annotated[
    list[Path] | None,
    typer.Option(
        "--tasks",
        parser=named_path,
        metavar="DIR",
        show_default=False,
        help="Additional folder of tasks. May be repeated.",
    ),
]
New = Annotated[
    bool,
    typer.Option(
        "--new",
        help="The participant is new. Without it, an unknown code is asked about, or refused if "
        "nobody can be.",
    ),
]
RecordedSession = Annotated[
    str,
    typer.Argument(
        metavar="SESSION|last", help="The session's id, or its beginning.", show_default=False
    ),
]
Code = Annotated[
    str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)
]
TaskName = Annotated[
    str,
    typer.Argument(
        metavar="TASK", help="The task's name; `sar-tui tasks` lists them.", show_default=False
    ),
]
Sessions = Annotated[
    list[str] | None,
    typer.Argument(metavar="[SESSION|last]…", help="Ids, or their beginnings.", show_default=False),
]
SessionsOf = Annotated[
    str | None,
    typer.Option(
        "-p",
        "--participant",
        metavar="CODE",
        show_default=False,
        help="Sessions of this participant.",
    ),
]
Everything = Annotated[bool, typer.Option("--all", help="All sessions.")]
Simulated = Annotated[
    bool, typer.Option("--simulated", help="Simulated sessions instead of live ones.")
]
Mixed = Annotated[bool, typer.Option("--mixed", help="Live and simulated sessions.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Pairs = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        show_default=False,
        help="Set a parameter of the task. May be repeated.",
    ),
]
Steps = Annotated[
    Path | None,
    typer.Option(
        "--steps",
        metavar="FILE.toml",
        show_default=False,
        help="Questions, screens to read and rests between attempts; see docs/ask-questions.md.",
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed",
        metavar="N",
        min=0,
        max=2**63 - 1,
        show_default=False,
        help="Seed of all randomness. Default: a random one.",
    ),
]
Outputs = Annotated[
    str | None,
    typer.Option(
        "--outputs",
        metavar="NAME,NAME",
        show_default=False,
        help="The agent's outputs: screen, speech, tones, servo, and robots, which `sar-tui robots` "
        "lists; the same as --set outputs=….",
    ),
]
Plain = Annotated[
    bool,
    typer.Option(
        "--plain",
        help="For screen readers and braille: lines that are appended, without a screen. Also by "
        "ACCESSIBLE=1.",
    ),
]
Markers = Annotated[
    list[str] | None,
    typer.Option(
        "--markers",
        metavar="WHERE",
        show_default=False,
        help="Send markers of events to lsl, udp://HOST:PORT or serial:PORT[@BAUD]. May be "
        "repeated.",
    ),
]
SyncFlash = Annotated[
    bool,
    typer.Option(
        "--sync-flash", help="Begin with a flash and a tone, to align the recordings of cameras."
    ),
]
Protocol = Annotated[
    Path | None,
    typer.Option(
        "--protocol",
        parser=named_path,
        metavar="FILE",
        show_default=False,
        help="The operator's protocol to work by: steps and rules, in TOML.",
    ),
]
Speech = Annotated[
    str | None,
    typer.Option(
        "--speech",
        metavar="WHERE",
        show_default=False,
        help="Let the agent speak: sound (loudspeaker) or file:DIR (a WAV file for each "
        "utterance).",
    ),
]
Language = Annotated[
    str | None,
    typer.Option(
        "--language",
        metavar="CODE",
        show_default=False,
        help="Language of the session: en, de, es.",
    ),
]


class Home(NamedTuple):
    """The data folder and the extra task folders, given before or after the command."""

    data: Path | None = None
    tasks: tuple[Path, ...] = ()

    @classmethod
    def of(
        cls, context: typer.Context, data: Path | None = None, tasks: Sequence[Path] | None = None
    ) -> "Home":
        """Combine a command's options with those of the commands above it."""
        above = context.find_object(cls) or cls()
        return cls(data or above.data, (*(tasks or ()), *above.tasks))

    @property
    def folder(self) -> Path:
        """The data folder."""
        from sar_tui.store.database import default_folder

        return self.data or default_folder()

    def catalogue(self) -> "Catalogue":
        """Return the installed tasks and themes. Raises PluginError if a folder does not exist."""
        from sar_tui.plugins import Catalogue

        return Catalogue(self.tasks)

    @contextmanager
    def database(self) -> "Iterator[sqlite3.Connection]":
        """Open the database to read it, say if data was lost, and close it afterwards. Raises
        StoreError.
        """
        from sar_tui.store.database import connect_to_read
        from sar_tui.store.troubles import troubles

        database = connect_to_read(self.folder)
        try:
            for text in troubles(database, self.folder):
                print(f"! {text}", file=sys.stderr)
            yield database
        finally:
            database.close()

    @contextmanager
    def writable_database(self) -> "Iterator[sqlite3.Connection]":
        """Open the database to write to it, made if there is none, and close it afterwards. Raises
        StoreError.
        """
        from sar_tui.store.database import connect

        database = connect(self.folder)
        try:
            yield database
        finally:
            database.close()

    @contextmanager
    def session(self, name: str) -> "Iterator[tuple[sqlite3.Connection, dict[str, Any]]]":
        """Open the database at a recorded session, given its id, the start of it, or ``last``.
        Raises StoreError.
        """
        from sar_tui.store.sessions import find

        with self.database() as database:
            yield database, find(database, self.folder, name)


def at_home(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command its parameter ``home``, if it has one, from the options --data and --tasks,
    which are added to its own.
    """
    own = dict(inspect.signature(command, eval_str=True).parameters)
    if own.pop("home", None) is None:
        return command
    takes_context = own.pop("context", None) is not None

    def run(context: typer.Context, data: Data = None, tasks: Tasks = None, **given: Any) -> Any:
        context.obj = home = Home.of(context, data, tasks)
        if takes_context:
            given["context"] = context
        return command(home=home, **given)

    context, data, tasks, _ = inspect.signature(run).parameters.values()
    parameters = [context, *own.values(), data, tasks]
    options: Any = run
    options.__signature__ = inspect.Signature(
        [each.replace(kind=each.KEYWORD_ONLY) for each in parameters]
    )
    options.__annotations__ = {each.name: each.annotation for each in parameters}
    options.__name__, options.__doc__ = command.__name__, command.__doc__
    return run


def watch_plugins(context: typer.Context) -> None:
    """End calls of a task's code that do not return, until the command is over."""
    from sar_tui.runs.plugin_watchdog import PluginWatchdog

    context.with_resource(PluginWatchdog(give_up))


def give_up(plugin: str) -> None:
    """End the program at once. For the watchdog's thread, while the command hangs in the code of a
    plug-in.
    """
    print(f"The {plugin} does not return from its own code.", file=sys.stderr, flush=True)
    os._exit(FAILED)


def console(*, error: bool = False) -> "Console":
    """Return a console for people. It honours NO_COLOR, and is plain if there is no terminal.

    It shows texts as they are, without markup and names of emoji.
    """
    from sar_tui.cli.tables import VisibleConsole

    return VisibleConsole(stderr=error, highlight=False, soft_wrap=False, markup=False, emoji=False)


def warn_of_git(path: Path) -> None:
    """Say on stderr if ``git add .`` would take a file or folder that was written, which holds data
    of people.
    """
    from sar_tui.drivers.git import is_safe_from

    if not is_safe_from(path):
        print(
            f"! git would add {path}: add it to .gitignore, or move it out of this work tree.",
            file=sys.stderr,
        )


def write_new(path: Path, text: str) -> None:
    """Write a file that only its owner can read, and warn of git. Raises Refused if it exists, or
    cannot be written.
    """
    from sar_tui.drivers.files import write_private

    try:
        write_private(path, text)
    except FileExistsError:
        raise Refused(
            f"{path} exists already, and is not overwritten. Name another file."
        ) from None
    except OSError as error:
        raise Refused(f"{path} cannot be written: {error.strerror}.") from error
    warn_of_git(path)


def print_json(value: object) -> None:
    """Print one line of JSON."""
    import json

    import msgspec

    from sar_tui.model.visible_text import escaped

    try:
        encoded = msgspec.json.encode(value, enc_hook=_plain_text).decode()
    except UnicodeEncodeError:  # a file's name that is not UTF-8
        encoded = json.dumps(msgspec.to_builtins(value, enc_hook=_plain_text), ensure_ascii=False)
    print(escaped(encoded))


def _plain_text(value: object) -> str:
    """Return a text of a subclass of ``str``, which msgspec does not encode, as a plain one."""
    if isinstance(value, str):
        return str(value)
    raise TypeError(f"{type(value).__name__} cannot be written as JSON.")


def checked_markers(given: Sequence[str] | None) -> tuple[str, ...]:
    """Return the addresses in --markers.

    Raises:
        Refused: an address is invalid.
        Failed: nothing can be sent to one of them now.
    """
    if not given:
        return ()
    from sar_tui.outputs.markers.destinations import make_destinations, split_addresses
    from sar_tui.outputs.markers.marker import MarkerError
    from sar_tui.runs.plan import Failed

    addresses = split_addresses(given)
    try:
        destinations = make_destinations(addresses)
    except MarkerError as error:
        raise Refused(str(error)) from error
    try:
        for destination in destinations:
            destination.check()
    except MarkerError as error:
        raise Failed(str(error)) from error
    return addresses


def read_settings(
    pairs: Sequence[str] | None, example: str = "--set attempts=10", **options: str | None
) -> dict[str, object]:
    """Return the task settings given as NAME=VALUE pairs and as options of their own. ``example``
    is one of the pairs' option.

    The last value of a name counts, and an option overrides a pair. Raises Refused.
    """
    found: dict[str, object] = {}
    for pair in pairs or ():
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            raise Refused(
                f"{example.split(maxsplit=1)[0]} takes NAME=VALUE, such as {example}, not {pair!r}."
            )
        found[name.strip()] = value
    return found | {name: value for name, value in options.items() if value is not None}


def steps_of(file: Path | None) -> "tuple[Step, ...]":
    """Return the steps of a file, if one is given. Raises Refused."""
    if file is None:
        return ()
    from sar_tui.rules.questions import StepFileError, read_steps

    try:
        return read_steps(file)
    except StepFileError as error:
        raise Refused(str(error)) from error


@contextmanager
def checked_settings(task: "type[Task]") -> Iterator[None]:
    """Turn a ParameterError into Refused, and add to its message where the settings of the task are
    listed.
    """
    from sar_tui.rules.declaration import ParameterError

    try:
        yield
    except ParameterError as error:
        raise Refused(f"{error} `sar-tui tasks show {task.name}` lists what can be set.") from error


def is_served() -> bool:
    """Return True if a browser shows this program's screen: `sar-tui serve` or textual-serve
    started it.
    """
    return "web_driver" in os.environ.get("TEXTUAL_DRIVER", "")


CANNOT_PLACE_TEXT = ("dumb", "unknown")
"""Kinds of terminals that only print line after line."""


def terminal_kind() -> str:
    """Return the kind of the terminal, as in TERM; empty if it is not known. Windows has one
    kind.
    """
    return os.environ.get("TERM", "" if os.name == "posix" else "windows")


def is_interactive() -> bool:
    """Return True if somebody can be asked on this terminal."""
    return all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stderr))


def are_new(database: "sqlite3.Connection", codes: Sequence[str], *, said: bool) -> bool:
    """Return True if participants of whom something is recorded now are new: it was said, or is
    answered here.

    Raises:
        Refused: somebody is not known, and nobody can be asked.
        StoreError: as `participants.admit`.
        Exit: the code was a typing error.
    """
    from sar_tui.store.participants import UnknownParticipant, admit

    try:
        admit(database, codes, is_new=said)
    except UnknownParticipant as unknown:
        if not is_interactive():
            raise Refused(unknown.advice) from None
        if not typer.confirm(f"{unknown} Is {unknown.code} a new participant?", err=True):
            print("Nothing was done.", file=sys.stderr)
            raise typer.Exit(FAILED) from None
        return True
    return said


def need_screen() -> None:
    """Raise Refused if there is neither a terminal nor a browser to show a screen."""
    if not is_served():
        need_terminal()


def is_plain(asked: bool) -> bool:
    """Return True if a session is to append lines for a screen reader: by ``--plain``, or by the
    environment variable ACCESSIBLE, as other programs.
    """
    return asked or os.environ.get("ACCESSIBLE", "0") not in ("", "0")


def need_terminal(*, plain: bool = False, sync_flash: bool = False) -> None:
    """Raise Refused if there is no terminal, or a browser shows the screen. ``plain``: lines are
    only appended, which cannot flash.
    """
    if plain and sync_flash:
        raise Refused("Plain lines have no screen that flashes: leave out --sync-flash.")
    if is_served():
        raise Refused(
            "A session cannot run in a browser, where responses cannot be timed. Use a terminal."
        )
    if not all(
        stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)
    ):
        reason = "its input or output is redirected"
    elif plain:
        return
    elif (term := terminal_kind()) in CANNOT_PLACE_TEXT:
        reason = f"this one (TERM={term}) cannot place text on the screen"
    elif not term:
        reason = (
            "the variable TERM, which names the kind of this one, is empty; a common value "
            "is xterm-256color"
        )
    else:
        return
    raise Refused(f"This needs a real terminal: {reason}. `sar-tui simulate` works without one.")
