"""``sar-tui timing --sound``: the delays of tones of prompts."""

import itertools
import sys

from sar_tui.cli.common import console, print_json
from sar_tui.cli.progress_line import progress_line
from sar_tui.cli.tables import add, table
from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.timing.tones import AHEAD_MS, ToneDelays, measure_tones
from sar_tui.tui.exit_codes import FAILED


def run(count: int, as_json: bool) -> int:
    """Measure, print, and return the exit code."""
    try:
        with progress_line("Playing tones", still=True) as show:
            done = itertools.count(1)
            found = measure_tones(
                count, on_tone=lambda: show("Playing tones", next(done), 2 * count)
            )
    except (SoundError, OSError) as error:
        print(f"The delays of tones could not be measured. {error}", file=sys.stderr)
        return FAILED
    if as_json:
        print_json({"sound": found})
    else:
        _print(found)
    return 0


def _print(found: ToneDelays) -> None:
    columns = ("median", "robust SD", "p99", "worst")
    made = table("delay, ms", "tones", *columns, right=("tones", *columns))
    named = {"requested at once": found.at_once, f"planned {AHEAD_MS} ms ahead": found.planned}
    for name, figures in named.items():
        shown = (figures.median_ms, figures.robust_sd_ms, figures.p99_ms, figures.max_ms)
        add(made, name, figures.n, *(f"{value:.2f}" for value in shown))
    out = console()
    out.print(made)
    out.print(
        f"\n{found.card}: a sample waits {found.buffer_ms:.0f} ms in its buffer, which is in "
        "these figures."
    )
    out.print(
        "Not in these figures: what comes after it, such as a sound server, a wireless "
        "loudspeaker, the air."
    )
