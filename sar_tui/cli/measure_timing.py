"""``sar-tui timing``: its options. `sar_tui.cli.timing` measures, and is loaded when the command
runs.
"""

from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks


def measure_timing(
    context: typer.Context,
    trials: Annotated[
        int, typer.Option(min=10, max=10_000, help="Number of responses to measure.")
    ] = 100,
    sound: Annotated[
        bool,
        typer.Option(
            "--sound", help="Measure the delays of tones instead: --trials of each kind, audible."
        ),
    ] = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Measure the timing of this machine.

    Reports whether it is fit for an experiment, and why. The figures are stored with later
    sessions, except those of tones.
    """
    if sound:
        from sar_tui.cli import timing_of_tones

        raise typer.Exit(timing_of_tones.run(trials, as_json))
    from sar_tui.cli import timing

    raise typer.Exit(timing.run(Home.of(context, data, tasks).folder, trials, as_json))
