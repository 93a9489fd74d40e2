"""``sar-tui adverse``: adverse events, reported and amended."""

from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, New, Tasks, are_new, console, print_json

if TYPE_CHECKING:
    from sar_tui.store.adverse_events import AdverseEvent

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_Code = Annotated[
    str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)
]
_Event = Annotated[str, typer.Argument(metavar="EVENT", help="The event's id.", show_default=False)]
_SEVERITIES = "mild, moderate or severe"


@app.callback()
def adverse() -> None:
    """Record adverse events: what happened, how severe it was, what was done, and how it ended."""


@app.command("add")
def add_event(
    context: typer.Context,
    participant: _Code,
    what: Annotated[
        str, typer.Option("--what", metavar="TEXT", show_default=False, help="What happened.")
    ],
    onset: Annotated[
        str,
        typer.Option(
            "--onset",
            metavar="DATE",
            show_default=False,
            help="When it began: 2026-03-01 or 2026-03-01T14:30.",
        ),
    ],
    severity: Annotated[
        str, typer.Option("--severity", metavar="HOW", show_default=False, help=f"{_SEVERITIES}.")
    ],
    action: Annotated[str, typer.Option("--action", metavar="TEXT", help="What was done.")] = "",
    outcome: Annotated[str, typer.Option("--outcome", metavar="TEXT", help="How it ended.")] = "",
    session: Annotated[
        str | None,
        typer.Option(
            "--session",
            metavar="SESSION|last",
            show_default=False,
            help="The session in which it began.",
        ),
    ] = None,
    new: New = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Report an adverse event."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import adverse_events, participants
    from sar_tui.store.database import StoreError
    from sar_tui.store.sessions import find

    home = Home.of(context, data, tasks)
    code = participants.check_code(participant)
    with home.writable_database() as database:
        found = find(database, home.folder, session) if session is not None else None
        if found and code not in (found["participant"], found["partner"]):
            raise StoreError(f"The session {found['id']} is not one of {code}.", bad_input=True)
        is_new = are_new(database, [participant], said=new)
        event = adverse_events.report(
            database,
            code,
            onset=onset,
            what=what,
            severity=severity,
            action=action,
            outcome=outcome,
            session=found["id"] if found else None,
            author=login_name(),
            is_new=is_new,
        )
    _print_saved(event, as_json=as_json)


@app.command("amend")
def amend_event(
    context: typer.Context,
    event: _Event,
    onset: Annotated[
        str | None, typer.Option("--onset", metavar="DATE", show_default=False)
    ] = None,
    what: Annotated[str | None, typer.Option("--what", metavar="TEXT", show_default=False)] = None,
    severity: Annotated[
        str | None, typer.Option("--severity", metavar="HOW", show_default=False, help=_SEVERITIES)
    ] = None,
    action: Annotated[
        str | None, typer.Option("--action", metavar="TEXT", show_default=False)
    ] = None,
    outcome: Annotated[
        str | None, typer.Option("--outcome", metavar="TEXT", show_default=False)
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Add what is known now of an adverse event, such as its outcome. What was recorded before is
    kept.
    """
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import adverse_events

    home = Home.of(context, data, tasks)
    with home.writable_database() as database:
        changed = adverse_events.amend(
            database,
            event,
            login_name(),
            onset=onset,
            what=what,
            severity=severity,
            action=action,
            outcome=outcome,
        )
    _print_saved(changed, as_json=as_json)


@app.command("list")
def list_events(
    context: typer.Context,
    participant: Annotated[
        str | None,
        typer.Option(
            "-p",
            "--participant",
            metavar="CODE",
            show_default=False,
            help="Events of this participant.",
        ),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """List the adverse events, as they are known now, by onset."""
    from sar_tui.store import adverse_events, participants

    code = participants.check_code(participant) if participant is not None else None
    with Home.of(context, data, tasks).database() as database:
        found = adverse_events.listing(database, code)
        if code and not found:
            participants.check_known(database, code)
    if as_json:
        print_json({"adverse_events": found})
        return

    from sar_tui.cli.tables import add, table

    out = console()
    if not found:
        out.print(f"There are no adverse events{f' of {code}' if code else ''}.")
        return
    made = table(
        "event",
        "onset",
        "who",
        "severity",
        "what",
        "action",
        "outcome",
        whole=("event", "severity"),
    )
    for one in found:
        add(
            made,
            one.event,
            one.onset,
            one.participant,
            one.severity,
            one.what,
            one.action,
            one.outcome,
        )
    out.print(made)


@app.command("show")
def show_event(
    context: typer.Context,
    event: _Event,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show all versions of an adverse event: who recorded what, and when."""
    from sar_tui.store import adverse_events
    from sar_tui.store.database import StoreError

    with Home.of(context, data, tasks).database() as database:
        found = adverse_events.versions(database, event)
    if not found:
        raise StoreError(
            f"There is no adverse event {event}. `sar-tui adverse list` lists them.", bad_input=True
        )
    if as_json:
        print_json({"versions": found})
        return

    from sar_tui.cli.tables import add, table
    from sar_tui.store.sessions import local_time

    made = table(
        "version",
        "recorded",
        "by",
        "onset",
        "what",
        "severity",
        "action",
        "outcome",
        right=("version",),
    )
    for one in found:
        recorded = (one.version, local_time(one.recorded_at), one.recorded_by)
        add(made, *recorded, one.onset, one.what, one.severity, one.action, one.outcome)
    out = console()
    out.print(f"Adverse event {event} of {found[0].participant}", soft_wrap=True, end="\n\n")
    out.print(made)


def _print_saved(event: "AdverseEvent", *, as_json: bool) -> None:
    if as_json:
        print_json({"adverse_event": event})
        return
    missing = [name for name in ("action", "outcome") if not getattr(event, name)]
    later = (
        f" Add later: `sar-tui adverse amend {event.event} "
        f"{' '.join(f'--{name} …' for name in missing)}`."
    )
    console().print(
        f"Adverse event {event.event} of {event.participant} is "
        f"recorded.{later if missing else ''}",
        soft_wrap=True,
    )
