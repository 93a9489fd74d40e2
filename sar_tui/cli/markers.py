"""``sar-tui markers``: send test markers, to see that they arrive."""

import time
from typing import Annotated

import typer

from sar_tui.cli.common import checked_markers


def markers(
    destinations: Annotated[
        list[str],
        typer.Argument(
            metavar="WHERE", help="lsl, udp://HOST:PORT or serial:PORT[@BAUD].", show_default=False
        ),
    ],
    count: Annotated[int, typer.Option(metavar="N", min=1, max=100_000, help="How many.")] = 10,
    every: Annotated[
        float, typer.Option(metavar="SECONDS", min=0, max=60, help="Time between two.")
    ] = 1.0,
) -> None:
    """Send test markers to other recorders.

    Start the recorder, and see that ten markers arrive, one a second. A session sends markers with
    `--markers`.
    """
    addresses = checked_markers(destinations)

    from sar_tui.loop.clock import host_now
    from sar_tui.outputs.markers.destinations import make_destinations
    from sar_tui.outputs.markers.marker import Marker
    from sar_tui.outputs.markers.sender import Sender
    from sar_tui.tui.exit_codes import FAILED

    troubles: list[str] = []

    def changed(state: str, why: str) -> None:
        if state == "failing":
            troubles.append(why)

    senders = [Sender(each, "test", "test", changed) for each in make_destinations(addresses)]
    try:
        for number in range(1, count + 1):
            for sender in senders:
                sender.put(Marker("test", host_now(), {"number": number}))
            if number < count:
                time.sleep(every)
    finally:
        for sender in senders:
            sender.finish()
    for sender in senders:
        unheard = f"; {sender.unheard} sent while nobody listened" if sender.unheard else ""
        print(f"{sender.address}: {sender.sent} sent, {sender.lost} lost{unheard}.")
    for trouble in troubles:
        print(f"! {trouble}")
    if any(sender.lost for sender in senders):
        raise typer.Exit(FAILED)
