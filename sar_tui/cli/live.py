"""``sar-tui run`` and ``sar-tui resume``: start or resume a live session."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from sar_tui.cli.common import (
    Home,
    Language,
    Markers,
    New,
    Outputs,
    Pairs,
    Plain,
    Seed,
    Speech,
    Steps,
    SyncFlash,
    TaskName,
    are_new,
    checked_markers,
    checked_settings,
    is_interactive,
    is_plain,
    need_terminal,
    read_settings,
    steps_of,
)
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.loop.task import Task
    from sar_tui.rules.parameters import TaskParameters
    from sar_tui.runs.plan import Plan
    from sar_tui.store.sessions import Row

AllowOperators = Annotated[
    bool,
    typer.Option("--operator", help="Let operators on this machine join, with `sar-tui wizard`."),
]
Listen = Annotated[
    str | None,
    typer.Option(
        "--listen",
        metavar="tls/HOST:PORT",
        show_default=False,
        help="Let invited operators join over the network; see `sar-tui link`.",
    ),
]


def run(
    home: Home,
    task: TaskName,
    participant: Annotated[
        list[str],
        typer.Option(
            "-p",
            "--participant",
            metavar="CODE",
            show_default=False,
            help="The participant's code, never a name. In a task for two, give it twice: left, "
            "then right.",
        ),
    ],
    settings: Pairs = None,
    imu: Annotated[
        str | None,
        typer.Option(
            "--imu",
            metavar="NAME",
            show_default=False,
            help="The motion sensor: phidget, simulated, recorded:FILE, session:ID; the same as "
            "--set imu=NAME.",
        ),
    ] = None,
    imu_trunk: Annotated[
        str | None,
        typer.Option(
            "--imu-trunk",
            metavar="NAME",
            show_default=False,
            help="A second motion sensor, on the breastbone; the same as --set imu_trunk=NAME.",
        ),
    ] = None,
    theme: Annotated[
        str | None,
        typer.Option(metavar="NAME", show_default=False, help="The theme. Default: the saved one."),
    ] = None,
    outputs: Outputs = None,
    speech: Speech = None,
    language: Language = None,
    steps: Steps = None,
    seed: Seed = None,
    operator: AllowOperators = False,
    listen: Listen = None,
    markers: Markers = None,
    sync_flash: SyncFlash = False,
    new: New = False,
    plain: Plain = False,
) -> None:
    """Start a session.

    It starts from the participant's programme; --set, --imu, --imu-trunk, --theme, --outputs,
    --speech and --language apply to this session only.
    """
    catalogue = home.catalogue()
    kind = catalogue.task(task)
    if imu is not None:
        _check_uses_sensor(kind, "imu", "no motion sensor")
    if imu_trunk is not None:
        _check_uses_sensor(kind, "imu_trunk", "no sensor on the trunk")
    given = read_settings(
        settings, imu=imu, imu_trunk=imu_trunk, outputs=outputs, language=language
    )

    from sar_tui.runs.plan import left_out_text, make_plan
    from sar_tui.store import programmes
    from sar_tui.store.database import connect_to_read
    from sar_tui.store.participants import check_code
    from sar_tui.store.sessions import new_id

    with home.database() as database:
        saved = programmes.newest(database, check_code(participant[0]), task)
    added = steps_of(steps)
    with checked_settings(kind):
        plan = make_plan(
            catalogue,
            kind,
            participant,
            given,
            saved=saved,
            theme=theme,
            speech=speech,
            seed=seed,
            id=new_id(),
            steps=added,
        )
    if text := left_out_text(plan):
        print(f"! {text}", file=sys.stderr)
    if kind.sensor_seats(plan.parameters):
        check_sensor(plan, home)
    elif imu is not None:
        raise Refused(
            f"The task {kind.name} uses no motion sensor with these settings: leave out --imu."
        )
    how = showing(markers, plain=plain, sync_flash=sync_flash, operator=operator, listen=listen)
    with closing(connect_to_read(home.folder)) as database:
        are_new(database, plan.participants, said=new)
    raise typer.Exit(play(home, plan, how))


class Showing(NamedTuple):
    """Means by which a session is shown in this terminal, and by which operators may join it.

    Attributes:
        markers: addresses to which its markers are sent.
        plain: True if lines are appended, for a screen reader.
        sync_flash: True to begin with a flash and a tone for cameras.
        operator: True if operators on this machine may join; ``listen``: where those of others may.
    """

    markers: tuple[str, ...] = ()
    plain: bool = False
    sync_flash: bool = False
    operator: bool = False
    listen: str | None = None


def showing(
    markers: Sequence[str] | None,
    *,
    plain: bool,
    sync_flash: bool,
    operator: bool = False,
    listen: str | None = None,
) -> Showing:
    """Return the means that options ask for. Raises Refused, Failed: they are not there."""
    found = Showing(checked_markers(markers), is_plain(plain), sync_flash, operator, listen)
    need_terminal(plain=found.plain, sync_flash=sync_flash)
    return found


def play(home: Home, plan: "Plan", how: Showing) -> int:
    """Run a new session in this terminal, and return the exit code.

    Raises:
        Refused: it cannot be told in lines, or nobody can listen where it is asked.
        Failed: operators cannot be let in.
    """
    given = plan.parameters
    if how.plain:
        _check_plain(plan.task, given, plan.seed)
    with _open_link(
        home,
        plan.id,
        plan.task.name,
        plan.participants,
        how.operator or given.operator_joins,
        how.listen,
        given.operator_lost_ms,
    ) as link:
        return _show(home, plan, how, link)


def play_on(home: Home, row: "Row", how: Showing) -> int:
    """Resume a session in this terminal, and return the exit code. Raises as `play`."""
    from sar_tui.rules.parameters import TaskParameters, build
    from sar_tui.store.sessions import codes

    stored = row["parameters"]
    if how.plain:
        kind = home.catalogue().task(row["task"])
        _check_plain(kind, build(kind.Parameters, stored), row["seed"])
    with _open_link(
        home,
        row["id"],
        row["task"],
        codes(row),
        how.operator or stored.get("operator_joins", False),
        how.listen,
        stored.get("operator_lost_ms", TaskParameters().operator_lost_ms),
    ) as link:
        return _show(home, row["id"], how, link)


def _show(home: Home, what: "Plan | str", how: Showing, link: "BrokerProcess | None") -> int:
    """Show a new session (a plan), or an interrupted one (its id)."""
    catalogue = home.catalogue()
    if how.plain:
        from sar_tui.app.plain import run_plain

        return run_plain(home.folder, catalogue, what, link=link, markers=how.markers)
    from sar_tui.app.app import run_app

    return run_app(
        home.folder, catalogue, what, link=link, markers=how.markers, sync_flash=how.sync_flash
    )


def _check_plain(kind: "type[Task]", parameters: "TaskParameters", seed: int) -> None:
    """Raise Refused if a session cannot be told in lines; say what has no effect in them."""
    from sar_tui.app.plain import untold
    from sar_tui.app.read_aloud import is_wanted
    from sar_tui.runs.plan import set_up

    if why := untold(set_up(kind, parameters), seed):
        raise Refused(why)
    if is_wanted(parameters):
        print(
            "! Nothing is read aloud in plain lines: that is left to the screen reader.",
            file=sys.stderr,
        )


@contextmanager
def _open_link(
    home: Home,
    session: str,
    task: str,
    participants: Sequence[str],
    operator: bool,
    listen: str | None,
    lost_ms: int,
) -> "Iterator[BrokerProcess | None]":
    """Open the session's link before the screen changes; yield None if neither option is given."""
    if not operator and listen is None:
        yield None
        return
    from sar_tui.link.errors import LinkError
    from sar_tui.link.listening import ListenOptions, open_link
    from sar_tui.runs.plan import Failed

    try:
        listening = ListenOptions.parse(operator=operator, listen=listen)
    except LinkError as error:
        raise Refused(str(error)) from error
    with ExitStack() as stack:
        try:
            broker = stack.enter_context(
                open_link(home.folder, session, task, participants, listening, lost_ms)
            )
        except LinkError as error:
            raise Failed(str(error)) from error
        yield broker


def _check_uses_sensor(kind: "type[Task]", parameter: str, which: str) -> None:
    from sar_tui.rules.parameters import fields

    if not any(field.name == parameter for field in fields(kind.Parameters)):
        raise Refused(
            f"The task {kind.name} uses {which}: leave out --{parameter.replace('_', '-')}."
        )


def check_sensor(plan: "Plan", home: Home) -> None:
    """Raise before the screen changes if a sensor does not exist. The app waits for one that is not
    plugged in.
    """
    from sar_tui.loop.clock import VirtualClock
    from sar_tui.runs.sensors import open_sensors

    open_sensors(plan.task, plan.parameters, plan.seed, VirtualClock(), home.folder)


def resume(
    home: Home,
    session: Annotated[
        str | None,
        typer.Argument(
            metavar="[SESSION|last]", help="The session's id, or its beginning.", show_default=False
        ),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="Resume the latest without a question.")
    ] = False,
    operator: AllowOperators = False,
    listen: Listen = None,
    markers: Markers = None,
    sync_flash: SyncFlash = False,
    plain: Plain = False,
) -> None:
    """Resume an interrupted session.

    Without an id, or with "last", it names the latest one and whose it is, and asks.
    """

    from sar_tui.runs.run import find_resumable
    from sar_tui.store.sessions import latest_interrupted

    with home.database() as database:
        if session in (None, "last"):
            latest = latest_interrupted(database, home.folder)
            if latest is None:
                raise Refused("There is no interrupted session to resume.")
            session = str(latest["id"])
            if not yes:
                _confirm(latest)
        chosen = find_resumable(database, home.folder, session or "")
    how = showing(markers, plain=plain, sync_flash=sync_flash, operator=operator, listen=listen)
    raise typer.Exit(play_on(home, chosen, how))


def _confirm(latest: "Row") -> None:
    """Ask if this session is meant.

    Raises:
        Refused: nobody can be asked.
        Exit: it is not.
    """
    from sar_tui.store.sessions import local_time, participant_codes

    done = f"{latest['attempts']} of {latest['parameters'].get('attempts', '?')} attempts done"
    began = local_time(latest["started_at"], latest["utc_offset_s"])
    print(
        f"The latest interrupted session is {latest['id']} of {participant_codes(latest)}: "
        f"{latest['task']}, "
        f"began {began}, {done}.",
        file=sys.stderr,
    )
    if not is_interactive():
        raise Refused(f"Nobody can be asked if it is meant. Name it: sar-tui resume {latest['id']}")
    if not typer.confirm("Resume it?", err=True):
        print(
            "Nothing was resumed. `sar-tui sessions` lists all sessions; `sar-tui resume ID` "
            "resumes one."
        )
        raise typer.Exit(FAILED)
