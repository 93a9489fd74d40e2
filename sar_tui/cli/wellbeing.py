"""``sar-tui wellbeing``: pain and tiredness of a participant over sessions."""

from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json


def wellbeing(
    context: typer.Context,
    participant: Annotated[str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the pain and tiredness of a participant over sessions, and what the therapist should know."""
    from sar_tui.framework.policies.wellbeing import tell_therapist
    from sar_tui.reports.wellbeing import advice
    from sar_tui.store import participants
    from sar_tui.store import wellbeing as store

    code = participants.check_code(participant)
    with Home.of(context, data, tasks).database() as database:
        rows = store.of_participant(database, code)
        reasons = tell_therapist(store.history(database, code))
    if as_json:
        print_json({"participant": code, "wellbeing": rows, "tell_therapist": reasons})
        return

    from sar_tui.cli.tables import add, table
    from sar_tui.store.sessions import local_time

    out = console()
    if not rows:
        out.print(
            f"Nothing is known of pain or tiredness of {code}.",
            soft_wrap=True,
        )
        return
    made = table("when", "session", "moment", "question", "answer")
    for row in rows:
        add(made, local_time(row["at"]), row["session"], row["moment"], row["question"], row["answer"])
    out.print(made)
    for text in advice(reasons):
        out.print(f"\n! {text}", soft_wrap=True)
