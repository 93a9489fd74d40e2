"""``sar-tui run`` and ``sar-tui resume``: straight into a session."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    Data,
    Home,
    Language,
    Outputs,
    Pairs,
    Seed,
    Speech,
    Tasks,
    checked_settings,
    need_terminal,
    read_settings,
)
from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.framework.task import Task
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.runs.plan import Plan

MayOperate = Annotated[
    bool, typer.Option("--operator", help="Let operators on this machine join, with `sar-tui wizard`.")
]
Listen = Annotated[
    str | None,
    typer.Option(
        "--listen",
        metavar="tls/HOST:PORT",
        show_default=False,
        help="Let those who were invited join over the network; see `sar-tui link`.",
    ),
]


def run(
    context: typer.Context,
    task: Annotated[
        str, typer.Argument(metavar="TASK", help="The task's name; `sar-tui tasks` lists them.", show_default=False)
    ],
    participant: Annotated[
        list[str],
        typer.Option(
            "-p",
            "--participant",
            metavar="CODE",
            show_default=False,
            help="Who: a code, never a name. Twice for a task for two: on the left, then on the right.",
        ),
    ],
    settings: Pairs = None,
    imu: Annotated[
        str | None,
        typer.Option(
            "--imu",
            metavar="NAME",
            show_default=False,
            help="The motion sensor: phidget, simulated, recorded:FILE, session:ID; the same as --set imu=NAME.",
        ),
    ] = None,
    theme: Annotated[
        str | None,
        typer.Option(metavar="NAME", show_default=False, help="How the agent looks and speaks; else as saved."),
    ] = None,
    outputs: Outputs = None,
    speech: Speech = None,
    language: Language = None,
    seed: Seed = None,
    operator: MayOperate = False,
    listen: Listen = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Go straight into a session.

    It starts from the participant's saved settings; --set, --imu, --theme, --outputs, --speech and --language hold for
    this session alone.
    """
    home = Home.of(context, data, tasks)
    catalogue = home.catalogue()
    kind = catalogue.task(task)
    if imu is not None:
        _refuse_without_sensor(kind)
    given = read_settings(settings, imu=imu, outputs=outputs, language=language)

    from sar_tui.runs.plan import make_plan
    from sar_tui.store import participants
    from sar_tui.store.sessions import new_id

    with home.database() as database:
        saved = participants.settings(database, participants.check_code(participant[0]), task)
    with checked_settings(kind):
        plan = make_plan(
            catalogue, kind, participant, given, saved=saved, theme=theme, speech=speech, seed=seed, id=new_id()
        )
    if kind.sensor_seats(plan.parameters):
        _refuse_unknown_sensor(plan, home)
    elif imu is not None:
        raise Refused(f"The task {kind.name} uses no motion sensor as it is set: leave out --imu, or set it otherwise.")
    need_terminal()
    with _link(home, plan.id, task, operator, listen, plan.parameters.operator_lost_ms) as link:
        from sar_tui.app.app import run_app

        ended = run_app(home.folder, catalogue, plan=plan, link=link)
    raise typer.Exit(ended)


@contextmanager
def _link(
    home: Home, session: str, task: str, operator: bool, listen: str | None, lost_ms: int
) -> "Iterator[BrokerProcess | None]":
    """The session's link, opened before the screen changes; without a word of it in the command, nothing at all."""
    if not operator and listen is None:
        yield None
        return
    from sar_tui.link.errors import LinkError
    from sar_tui.link.server import ListenOptions, open_link
    from sar_tui.runs.plan import Failed

    try:
        listening = ListenOptions.parse(operator=operator, listen=listen)
    except LinkError as error:
        raise Refused(str(error)) from error
    with ExitStack() as stack:
        try:
            host = stack.enter_context(open_link(home.folder, session, task, listening, lost_ms))
        except LinkError as error:
            raise Failed(str(error)) from error
        yield host


def _refuse_without_sensor(kind: "type[Task]") -> None:
    from sar_tui.framework.parameters import fields

    if not any(field.name == "imu" for field in fields(kind.Parameters)):
        raise Refused(f"The task {kind.name} uses no motion sensor: leave out --imu.")


def _refuse_unknown_sensor(plan: "Plan", home: Home) -> None:
    """A sensor that cannot be is told of before the screen changes; one that is not plugged in is waited for there."""
    from sar_tui.framework.clock import VirtualClock
    from sar_tui.runs.sensors import open_sensors

    open_sensors(plan.task, plan.parameters, plan.seed, VirtualClock(), home.folder)


def resume(
    context: typer.Context,
    session: Annotated[
        str, typer.Argument(metavar="[SESSION|last]", help="Its id, or the beginning of it.", show_default=False)
    ] = "last",
    operator: MayOperate = False,
    listen: Listen = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Go on with an interrupted session.

    Without an argument: the latest.
    """
    home = Home.of(context, data, tasks)
    catalogue = home.catalogue()

    from sar_tui.framework.parameters import TaskParameters
    from sar_tui.runs.run import find_resumable
    from sar_tui.store.sessions import listing

    with home.database() as database:
        if session == "last":
            rows = listing(database, home.folder)
            session = next((r["id"] for r in rows if (r["status"], r["mode"]) == ("interrupted", "live")), "")
            if not session:
                raise Refused("There is no interrupted session to resume.")
        chosen = find_resumable(database, home.folder, session)
    need_terminal()
    lost_ms = chosen["parameters"].get("operator_lost_ms", TaskParameters().operator_lost_ms)
    with _link(home, chosen["id"], chosen["task"], operator, listen, lost_ms) as link:
        from sar_tui.app.app import run_app

        ended = run_app(home.folder, catalogue, resume=chosen["id"], link=link)
    raise typer.Exit(ended)
