"""``sar-tui wellbeing``: pain and tiredness of a participant over sessions."""

from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json

if TYPE_CHECKING:
    from sar_tui.reports.wellbeing import Visit

_ID = 6
"""Characters of a session's id that are printed."""


def wellbeing(
    context: typer.Context,
    participant: Annotated[
        str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the pain and tiredness of a participant over sessions, and what the therapist should
    know.
    """
    from sar_tui.reports.wellbeing import advice, by_visit, dated_event
    from sar_tui.rules.wellbeing import tell_therapist
    from sar_tui.store import adverse_events, participants
    from sar_tui.store import wellbeing as store

    with Home.of(context, data, tasks).database() as database:
        code = participants.check_known(database, participant)
        rows = store.of_participant(database, code)
        limits = store.limits_of(database, [row["session"] for row in rows if row["session"]])
        reasons = tell_therapist(store.history(database, code))
        events = adverse_events.listing(database, code)
    if as_json:
        print_json(
            {
                "participant": code,
                "wellbeing": rows,
                "tell_therapist": reasons,
                "adverse_events": events,
            }
        )
        return

    out = console()
    for text in advice(reasons):
        out.print(f"! {text}", soft_wrap=True)
    for event in events:
        out.print(f"! {dated_event(event)}", soft_wrap=True)
    if reasons or events:
        out.print()
    if rows:
        _print_answers(by_visit(rows, limits))
    else:
        out.print(f"Nothing is known of pain or tiredness of {code}.", soft_wrap=True)


def _print_answers(visits: "list[Visit]") -> None:
    """Print a row for each session with what was said in it, in words."""
    from sar_tui.cli.tables import add, table
    from sar_tui.store.sessions import local_time

    made = table("date", "session", "what was said", whole=("date", "session"))
    for visit in visits:
        add(made, local_time(visit.at), visit.session[:_ID] or "not begun", " ".join(visit.said))
    console().print(made)
