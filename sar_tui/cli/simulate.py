"""``sar-tui simulate``: a whole session with a simulated participant."""

from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Home,
    Language,
    Outputs,
    Pairs,
    Seed,
    Speech,
    Steps,
    TaskName,
    checked_settings,
    console,
    print_json,
    read_settings,
    steps_of,
    watch_plugins,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line

if TYPE_CHECKING:
    from sar_tui.simulation.participant_model import Person


class User(StrEnum):
    """Names of `simulation.participant_model.PEOPLE`, which ``--help`` does not import."""

    poor = "poor"
    average = "average"
    competent = "competent"


class OperatorName(StrEnum):
    """Names of `simulation.operator.PROFILES`."""

    careful = "careful"
    hasty = "hasty"
    absent = "absent"


def simulate(
    context: typer.Context,
    home: Home,
    task: TaskName,
    user: Annotated[
        list[User],
        typer.Option(
            help="Skill of the simulated participant. In a task for two, give it twice: left, "
            "then right.",
            show_default=False,
        ),
    ],
    participant: Annotated[
        list[str] | None,
        typer.Option(
            "-p",
            "--participant",
            metavar="CODE",
            show_default=False,
            help="The participant's code. Default: SIM. In a task for two, give it twice.",
        ),
    ] = None,
    attempts: Annotated[
        int | None,
        typer.Option(
            metavar="N", show_default=False, help="Number of attempts. Default: the task's."
        ),
    ] = None,
    seed: Seed = None,
    steps: Steps = None,
    settings: Pairs = None,
    theme: Annotated[str, typer.Option(metavar="NAME", help="The theme.")] = "calm",
    outputs: Outputs = None,
    speech: Speech = None,
    language: Language = None,
    practice_effect: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE",
            min=0,
            max=0.9,
            show_default=False,
            help="Share by which practice shortens the reaction time, 0 to 0.9.",
        ),
    ] = None,
    fatigue: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE",
            min=0,
            max=1,
            show_default=False,
            help="Share by which each attempt lengthens the reaction time, 0 to 1.",
        ),
    ] = None,
    operator: Annotated[
        OperatorName | None,
        typer.Option(
            show_default=False,
            help="Simulate an operator: careful, hasty (often wrong) or absent (comes and goes). "
            "Feedback then needs "
            "approval (operator_feedback=approve), unless --set says otherwise.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a session with a simulated participant, or two in a task for two.

    It runs the same nodes as a live session, on a clock that jumps from one event to the next, into
    the database.
    """
    watch_plugins(context)
    catalogue = home.catalogue()
    kind = catalogue.task(task)
    values = read_settings(settings, outputs=outputs, language=language)
    if attempts is not None:
        values["attempts"] = attempts
    if operator is not None:
        values.setdefault("operator_feedback", "approve")

    from sar_tui.reports.output_summary import output_summaries
    from sar_tui.runs.plan import make_plan
    from sar_tui.runs.simulate import simulate as run_session
    from sar_tui.simulation.operator import PROFILES
    from sar_tui.store import sessions

    if len(user) > len(kind.seats):
        raise Refused(f"The task {kind.name} is for {len(kind.seats)}: give --user no more often.")
    added = steps_of(steps)
    with checked_settings(kind):
        plan = make_plan(
            catalogue,
            kind,
            participant or ["SIM"],
            values,
            theme=theme,
            speech=speech,
            seed=seed,
            mode="simulated",
            steps=added,
        )
    people = [_person(each, practice_effect, fatigue) for each in user]
    profile = None if operator is None else PROFILES[operator.value]
    of = plan.parameters.practice_attempts + plan.parameters.attempts
    with progress_line("Simulating") as show:

        def advance(attempt: int) -> None:
            show("Simulating", attempt, of)

        session = run_session(plan, people[0], home.folder, catalogue, advance, profile, people[-1])
    with home.database() as database:
        rows = sessions.rows(database, "attempts", session)
        spoke = output_summaries(database, session)
    if as_json:
        print_json({"session": session, "attempts": rows, "outputs": spoke})
        return

    from sar_tui.cli.sessions import print_failed_outputs
    from sar_tui.cli.tables import attempts_table, summary
    from sar_tui.widgets.task_view import stored_findings

    given = "".join(f" --tasks {folder}" for folder in home.tasks)
    out = console()
    out.print(attempts_table(rows, kind.metric, kind.measured))
    said = summary(rows, kind.metric, partial(stored_findings, kind))
    out.print(
        f"{said} Seed {plan.seed}. `sar-tui show {session}{given}` shows more.", soft_wrap=True
    )
    if operator is not None:
        out.print(f"`sar-tui report wizard {session}` shows what the operator did.", soft_wrap=True)
    print_failed_outputs(out, spoke)


def _person(user: User, practice: float | None, fatigue: float | None) -> "Person":
    import msgspec

    from sar_tui.simulation.participant_model import PEOPLE

    changes = {"practice": practice, "fatigue": fatigue}
    return msgspec.structs.replace(
        PEOPLE[user.value], **{name: value for name, value in changes.items() if value is not None}
    )
