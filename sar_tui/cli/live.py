"""``sar-tui run`` and ``sar-tui resume``: straight into a session."""

from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.agent import Language, Outputs, Speech, agent_parameters
from sar_tui.cli.common import Data, Home, Pairs, Seed, Tasks, need_terminal, new_seed
from sar_tui.cli.errors import Refused
from sar_tui.cli.setting import pairs

if TYPE_CHECKING:
    from sar_tui.framework.task import Task
    from sar_tui.runs import Plan


def run(
    context: typer.Context,
    task: Annotated[
        str, typer.Argument(metavar="TASK", help="The task's name; `sar-tui tasks` lists them.", show_default=False)
    ],
    participant: Annotated[
        str, typer.Option("-p", "--participant", metavar="CODE", show_default=False, help="Who: a code, never a name.")
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
    given = pairs(settings)
    if imu is not None:
        _refuse_without_sensor(kind)
        given["imu"] = imu
    agent_parameters(kind, given, outputs, speech, language)

    from sar_tui.runs import Plan, check_outputs
    from sar_tui.store import participants

    code = participants.check_code(participant)
    with home.database() as database:
        saved = participants.settings(database, code, task)
    parameters = agent_parameters(kind, {**saved.parameters, **given}, outputs, speech, language)
    check_outputs(parameters)
    plan = Plan(
        task=kind,
        parameters=parameters,
        theme=catalogue.theme(theme or saved.theme, parameters.language).name,
        participant=code,
        seed=new_seed() if seed is None else seed,
    )
    if kind.sensors:
        _refuse_unknown_sensor(plan, home)
    need_terminal()
    from sar_tui.app.app import run_app

    raise typer.Exit(run_app(home.folder, catalogue, plan=plan))


def _refuse_without_sensor(kind: "type[Task]") -> None:
    from sar_tui.framework.parameters import fields

    if not any(field.name == "imu" for field in fields(kind.Parameters)):
        raise Refused(f"The task {kind.name} uses no motion sensor: leave out --imu.")


def _refuse_unknown_sensor(plan: "Plan", home: Home) -> None:
    """A sensor that cannot be is told of before the screen changes; one that is not plugged in is waited for there."""
    from sar_tui.framework.clock import VirtualClock
    from sar_tui.sensing import sensor

    sensor(plan.parameters, plan.seed, VirtualClock(), home.folder)


def resume(
    context: typer.Context,
    session: Annotated[
        str, typer.Argument(metavar="[SESSION|last]", help="Its id, or the beginning of it.", show_default=False)
    ] = "last",
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Go on with an interrupted session.

    Without an argument: the latest.
    """
    home = Home.of(context, data, tasks)
    catalogue = home.catalogue()

    from sar_tui.runs import resumable
    from sar_tui.store.sessions import listing

    with home.database() as database:
        if session == "last":
            rows = listing(database, home.folder)
            session = next((r["id"] for r in rows if (r["status"], r["mode"]) == ("interrupted", "live")), "")
            if not session:
                raise Refused("No session was interrupted, so there is none to go on with.")
        chosen = resumable(database, home.folder, session)["id"]
    need_terminal()
    from sar_tui.app.app import run_app

    raise typer.Exit(run_app(home.folder, catalogue, resume=chosen))
