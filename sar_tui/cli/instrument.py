"""``sar-tui instrument``: scores of other instruments, entered by hand."""

from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, New, Tasks, are_new, console, print_json

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)


@app.callback()
def instrument() -> None:
    """Enter scores of other instruments, such as the FMA-UE, for `sar-tui progress`."""


@app.command("list")
def list_instruments(as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """List the instruments, with published detectable and important changes and their sources."""
    from sar_tui.progress.instruments import INSTRUMENTS

    if as_json:
        print_json({"instruments": list(INSTRUMENTS.values())})
        return
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.progress_words import published

    made = table("name", "instrument", "score", "published", whole=("name", "score"))
    for each in INSTRUMENTS.values():
        values = "\n".join(published(one, each) for one in each.published)
        add(made, each.name, each.title, f"{each.lowest:g} to {each.highest:g} {each.unit}", values)
    console().print(made)


@app.command("add")
def add_score(
    context: typer.Context,
    participant: Annotated[
        str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)
    ],
    name: Annotated[
        str,
        typer.Argument(
            metavar="INSTRUMENT", help="`sar-tui instrument list` lists them.", show_default=False
        ),
    ],
    score: Annotated[float, typer.Argument(metavar="SCORE", help="The score.", show_default=False)],
    on: Annotated[
        str,
        typer.Option(
            "--on", metavar="DATE", show_default=False, help="The day it was measured: 2026-03-01."
        ),
    ],
    note: Annotated[
        str,
        typer.Option("--note", metavar="TEXT", help="Such as the goal of GAS, or the assessor."),
    ] = "",
    new: New = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Enter a score. A second one for the same day replaces the first, which is kept in the
    database.
    """
    from sar_tui.drivers.login_name import login_name
    from sar_tui.progress.instruments import Score
    from sar_tui.store import instrument_scores, participants

    home = Home.of(context, data, tasks)
    with home.writable_database() as database:
        is_new = are_new(database, [participant], said=new)
        code = participants.check_own(participant)
        stored = instrument_scores.add(
            database, code, Score(name, on, score, note), author=login_name(), is_new=is_new
        )
    if as_json:
        print_json({"participant": code, **_plain(stored)})
        return
    console().print(
        f"{stored.instrument} {stored.score:g} of {code}, {stored.date}, is saved.", soft_wrap=True
    )


@app.command("remove")
def remove_score(
    context: typer.Context,
    participant: Annotated[
        str, typer.Argument(metavar="CODE", help="The participant's code.", show_default=False)
    ],
    name: Annotated[
        str, typer.Argument(metavar="INSTRUMENT", help="The instrument.", show_default=False)
    ],
    on: Annotated[
        str, typer.Option("--on", metavar="DATE", show_default=False, help="The day of the score.")
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Remove a score that was entered by mistake. It no longer counts, and is kept in the
    database.
    """
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import instrument_scores, participants

    home = Home.of(context, data, tasks)
    with home.writable_database() as database:
        code = participants.check_known(database, participant)
        removed = instrument_scores.remove(database, code, name, on, author=login_name())
    if as_json:
        print_json({"participant": code, **_plain(removed)})
        return
    console().print(
        f"{removed.instrument} {removed.score:g} of {code}, {removed.date}, is removed, and kept "
        "in the database.",
        soft_wrap=True,
    )


def _plain(stored: object) -> dict[str, object]:
    import msgspec

    plain: dict[str, object] = msgspec.to_builtins(stored)
    return plain
