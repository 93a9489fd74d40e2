"""``sar-tui replay``: a recorded session again, from its inputs."""

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Home,
    RecordedSession,
    console,
    need_screen,
    print_json,
    read_settings,
    watch_plugins,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    import sqlite3

    from sar_tui.model.trial_types import Metric
    from sar_tui.replay.fork import Forked
    from sar_tui.replay.rescore import Rescored
    from sar_tui.store.sessions import Row


def replay(
    context: typer.Context,
    home: Home,
    session: RecordedSession,
    what_if: Annotated[
        list[str] | None,
        typer.Option(
            "--what-if",
            metavar="NAME=VALUE",
            show_default=False,
            help="Score the recorded responses by another setting of difficulty, feedback or "
            "detector, as far as the "
            "prompts would have been the same. May be repeated.",
        ),
    ] = None,
    fork: Annotated[
        bool,
        typer.Option(
            "--fork",
            help="With --what-if, go on after the first prompt that would have been another, with "
            "a model of this "
            "participant's key presses: many runs, and an interval. Any setting may be changed.",
        ),
    ] = False,
    runs: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=20,
            max=10_000,
            show_default=False,
            help="Runs of a fork; few make the interval too narrow. Default: 200.",
        ),
    ] = None,
    watch: Annotated[
        bool,
        typer.Option(
            "--watch",
            help="Show the session again on the participant's screen, for watching only: Space "
            "pauses, left and right "
            "jump an attempt, + and - change the speed, Q leaves.",
        ),
    ] = False,
    speed: Annotated[
        float | None,
        typer.Option(
            metavar="TIMES",
            min=0.25,
            max=16,
            show_default=False,
            help="Speed of --watch. Default: 1.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a recorded session again from its inputs, and compare it with its record."""
    from sar_tui.replay.replay import replay as run_again
    from sar_tui.replay.rescore import rescore
    from sar_tui.replay.words import sentences

    watch_plugins(context)
    changed = read_settings(what_if, "--what-if threshold=900")
    if fork and not changed:
        raise Refused("--fork needs --what-if NAME=VALUE: another setting to go on with.")
    if runs is not None and not fork:
        raise Refused("--runs is for --fork only.")
    if speed is not None and not watch:
        raise Refused("--speed is for --watch only.")
    if watch and (changed or as_json):
        raise Refused(
            "--watch shows the session as it was: give neither --what-if nor --json with it."
        )
    if watch:
        _watch(home, session, speed or 1.0)
    with home.session(session) as (database, found):
        database.execute("PRAGMA query_only=ON")
        if fork:
            forked = _fork(database, home, found, changed, runs)
            print_json(forked) if as_json else _print_forked(
                forked, home.catalogue().task(found["task"]).metric
            )
            return
        if changed:
            with progress_line("Scoring"):
                rescored = rescore(database, home.folder, home.catalogue(), found, changed)
            print_json(rescored) if as_json else _print(rescored)
            return
        with progress_line("Replaying") as show:
            replayed = run_again(
                database,
                home.folder,
                home.catalogue(),
                found,
                lambda done, of: show("Replaying", done, of),
            )
    if as_json:
        print_json(replayed)
    else:
        for sentence in sentences(replayed):
            console().print(sentence, soft_wrap=True)
    if not replayed.identical:
        raise typer.Exit(FAILED)


def _watch(home: Home, session: str, speed: float) -> None:
    """Show a session in this terminal, and exit."""
    need_screen()
    from sar_tui.app.app import find_picture_way
    from sar_tui.app.watch import Watch
    from sar_tui.replay.replay import check_whole

    with home.session(session) as (database, found):
        check_whole(database, home.folder, found)
        app = Watch(home.folder, home.catalogue(), database, found, speed).app
    find_picture_way(app)
    code = app.run_here()
    if app.failure:
        print(app.failure, file=sys.stderr)
    raise typer.Exit(code)


def _fork(
    database: "sqlite3.Connection",
    home: Home,
    row: "Row",
    changed: dict[str, object],
    runs: int | None,
) -> "Forked":
    from sar_tui.replay.fork import RUNS
    from sar_tui.replay.fork import fork as fork_session

    count = runs or RUNS
    with progress_line("Simulating") as show:
        return fork_session(
            database,
            home.folder,
            home.catalogue(),
            row,
            changed,
            count,
            lambda done: show("Simulating", done, count),
        )


def _print_forked(forked: "Forked", metric: "Metric") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.replay.words import forked_sentences

    heading, told = forked_sentences(forked)
    numbers = ("recorded", "median", "low", "high")
    made = table("", *numbers, right=numbers)
    for one in forked.numbers:
        name = f"mean {metric.label}" if one.name == "mean_metric" else one.name.replace("_", " ")
        add(
            made,
            name,
            *(
                None if value is None else f"{value:.4g}"
                for value in (getattr(one, n) for n in numbers)
            ),
        )
    out = console()
    out.print(heading, style="bold")
    out.print(made)
    for sentence in told:
        out.print(sentence, soft_wrap=True)


def _print(rescored: "Rescored") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.replay.words import rescored_sentences

    numbers = ("attempt", "level", "result, recorded", "result, now")
    made = table(
        *numbers[:2], "seat", *numbers[2:], "outcome, recorded", "outcome, now", right=numbers
    )
    for one in rescored.attempts:
        was, now = one.recorded, one.rescored
        results = [None if score.metric is None else f"{score.metric:.1f}" for score in (was, now)]
        add(made, one.attempt, one.level, one.seat, *results, was.outcome, now.outcome)
    out = console()
    out.print(made)
    for sentence in rescored_sentences(rescored):
        out.print(sentence, soft_wrap=True)
