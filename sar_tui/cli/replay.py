"""``sar-tui replay``: a recorded session again, from its inputs."""

from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, RecordedSession, Tasks, console, print_json, watch_plugins
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.replay.rescore import Rescored


def replay(
    context: typer.Context,
    session: RecordedSession,
    what_if: Annotated[
        list[str] | None,
        typer.Option(
            "--what-if",
            metavar="NAME=VALUE",
            show_default=False,
            help="Score the recorded responses by another setting of difficulty, feedback or detector, as far as the "
            "prompts would have been the same. May be repeated.",
        ),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Run a recorded session again from its inputs, and compare it with its record."""
    from sar_tui.replay.replay import replay as run_again
    from sar_tui.replay.rescore import rescore
    from sar_tui.replay.words import sentences

    watch_plugins(context)
    home = Home.of(context, data, tasks)
    changed = _read(what_if or [])
    with home.session(session) as (database, found):
        database.execute("PRAGMA query_only=ON")
        if changed:
            rescored = rescore(database, home.folder, home.catalogue(), found, changed)
            print_json(rescored) if as_json else _print(rescored)
            return
        replayed = run_again(database, home.folder, home.catalogue(), found)
    if as_json:
        print_json(replayed)
    else:
        for sentence in sentences(replayed):
            console().print(sentence, soft_wrap=True)
    if not replayed.identical:
        raise typer.Exit(FAILED)


def _read(pairs: list[str]) -> dict[str, object]:
    """Return the settings given as NAME=VALUE. Raises Refused."""
    found: dict[str, object] = {}
    for pair in pairs:
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            raise Refused(f"--what-if takes NAME=VALUE, such as --what-if threshold=900, not {pair!r}.")
        found[name.strip()] = value
    return found


def _print(rescored: "Rescored") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.replay.words import rescored_sentences

    numbers = ("attempt", "level", "result, recorded", "result, now")
    made = table(*numbers[:2], "seat", *numbers[2:], "outcome, recorded", "outcome, now", right=numbers)
    for one in rescored.attempts:
        was, now = one.recorded, one.rescored
        results = [None if score.metric is None else f"{score.metric:.1f}" for score in (was, now)]
        add(made, one.attempt, one.level, one.seat, *results, was.outcome, now.outcome)
    out = console()
    out.print(made)
    for sentence in rescored_sentences(rescored):
        out.print(sentence, soft_wrap=True)
