"""``sar-tui replay``: a recorded session again, from its inputs."""

import typer

from sar_tui.cli.common import AsJson, Data, Home, RecordedSession, Tasks, console, print_json, watch_plugins
from sar_tui.tui.exit_codes import FAILED


def replay(
    context: typer.Context,
    session: RecordedSession,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Run a recorded session again from its inputs, and compare it with its record."""
    from sar_tui.replay.replay import replay as run_again
    from sar_tui.replay.words import sentences

    watch_plugins(context)
    home = Home.of(context, data, tasks)
    with home.session(session) as (database, found):
        database.execute("PRAGMA query_only=ON")
        replayed = run_again(database, home.folder, home.catalogue(), found)
    if as_json:
        print_json(replayed)
    else:
        for sentence in sentences(replayed):
            console().print(sentence, soft_wrap=True)
    if not replayed.identical:
        raise typer.Exit(FAILED)
