"""``sar-tui robots``: which robots can be used, whether they are there, and how soon they stop."""

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, console, print_json
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.outputs.examination import Examined, Tried, What

FORMS = (
    ("ros4hri://HOST[:9090]", "a robot with ROS4HRI skills, over rosbridge"),
    ("furhat://HOST[:9000]", "a Furhat, with its realtime API switched on"),
    ("reachy://HOST[:8000]", "a Reachy Mini, whose daemon runs"),
    ("ros://HOST[:9090]", "a robot of your own on ROS, over rosbridge"),
    ("servo", "RC servos on a Phidget controller"),
)
"""The forms of addresses, and what they are for."""
_KINDS = tuple(form.partition(":")[0] for form, _ in FORMS)
_GESTURES = {"servo": "wave"}
"""Gestures to try where there may be no neck: one servo is an arm."""
_REMEMBERED = 200
"""The sessions in which addresses are looked for."""


def robots(
    home: Home,
    address: Annotated[
        str | None,
        typer.Argument(metavar="[ADDRESS]", help="A robot to try out, as for --outputs."),
    ] = None,
    say: Annotated[
        str | None,
        typer.Option("--say", metavar="TEXT", show_default=False, help="The sentence it says."),
    ] = None,
    gesture: Annotated[
        str | None,
        typer.Option(
            "--gesture",
            metavar="NAME",
            show_default=False,
            help="The gesture it makes, such as nod.",
        ),
    ] = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Only see whether it is there: no word, no movement.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Tell which robots of earlier sessions are there, or try one out: it speaks, moves, and stops.

    Exit code 1 if the robot is not there, fails, or does not confirm that it stopped.
    """
    if address is None:
        if say is not None or gesture is not None or quiet:
            raise Refused("Name the robot: sar-tui robots ADDRESS.")
        _list(home, as_json)
        return
    from sar_tui.outputs.examination import What

    if quiet and (say is not None or gesture is not None):
        raise Refused("--quiet goes without --say and --gesture.")
    words = "Hello. I am here." if say is None else say
    if quiet and _kind(address) == "servo":
        raise Refused("Servos are seen when they move, or by `sar-tui doctor`: leave out --quiet.")
    move = gesture if gesture is not None else _GESTURES.get(_kind(address), "nod")
    what = What() if quiet else What(words, move)
    tell = console(error=True)
    (found,) = _examined(home, [address], what, lambda text: tell.print(text, markup=False))
    if as_json:
        print_json(found)
    else:
        _print(found)
    if not found.reachable or _has_failed(found):
        raise typer.Exit(FAILED)


def _list(home: Home, as_json: bool) -> None:
    from sar_tui.outputs.examination import What

    found = _examined(home, _remembered(home), What(), lambda _: None)
    if as_json:
        print_json({"robots": found, "to_name": [form for form, _ in FORMS]})
        return
    out = console()
    for each in found:
        state = "reachable" if each.reachable else " ".join(each.problems)
        out.print(f"{each.address}: {state}", soft_wrap=True, markup=False)
    if not found:
        out.print("No robot has been used in the sessions here.")
    out.print("A robot is named in --outputs by:")
    for form, what in FORMS:
        out.print(f"  {form:24} {what}", soft_wrap=True, markup=False)
    out.print("`sar-tui robots ADDRESS` tries one out.")


def _remembered(home: Home) -> list[str]:
    """Return the addresses of robots in earlier sessions, the newest first."""
    from sar_tui.store.database import FILE
    from sar_tui.store.sessions import listing

    if not (home.folder / FILE).exists():
        return []
    with home.database() as database:
        rows = listing(database, home.folder, limit=_REMEMBERED, also_damaged=True)
    addresses = [
        address
        for row in rows
        for address in row["parameters"].get("outputs", ())
        if _kind(address) in _KINDS and _kind(address) != "servo"
    ]
    return list(dict.fromkeys(addresses))


def _examined(
    home: Home, addresses: list[str], what: "What", tell: Callable[[str], object]
) -> "list[Examined]":
    """Try several out at the same time. Raises Refused for an address that is not a robot's."""
    from sar_tui.outputs.examination import examine
    from sar_tui.outputs.output import OutputError
    from sar_tui.outputs.outputs import open_outputs

    theme = home.catalogue().theme("calm")
    if what.gesture and what.gesture not in theme.gestures:
        known = ", ".join(theme.gestures)
        raise Refused(f"There is no gesture {what.gesture}. Choose one of: {known}.")
    outputs = []
    for address in addresses:
        if _kind(address) not in _KINDS:
            known = ", ".join(form for form, _ in FORMS)
            raise Refused(f"{address or 'An empty address'} is not a robot. Use one of: {known}.")
        try:
            (node,) = open_outputs([address], "sound", theme)
        except OutputError as error:
            raise Refused(str(error)) from error
        outputs.append(node.output)

    async def all_of_them() -> "list[Examined]":
        trials = [
            examine(address, output, theme, what, tell)
            for address, output in zip(addresses, outputs, strict=True)
        ]
        return list(await asyncio.gather(*trials))

    return asyncio.run(all_of_them())


def _kind(address: str) -> str:
    return address.strip().partition(":")[0]


def _has_failed(found: "Examined") -> bool:
    parts = [tried for tried in (found.said, found.moved) if tried]
    unstopped = found.stopped is not None and found.stopped.took_ms is None
    return unstopped or any(tried.state != "done" for tried in parts)


def _print(found: "Examined") -> None:
    out = console()

    def line(title: str, text: str) -> None:
        out.print(f"{title:8} {text}", soft_wrap=True, markup=False)

    def tried(title: str, part: "Tried | None") -> None:
        if part and part.started_ms is not None:
            line(
                title,
                f"began after {part.started_ms:.0f} ms, {part.state} after {part.ended_ms:.0f} ms",
            )
        elif part:
            line(title, part.state)

    if found.reachable:
        line("Robot", f"reachable, connected after {found.connected_ms:.0f} ms")
    tried("Speech", found.said)
    tried("Gesture", found.moved)
    if found.stopped and found.stopped.took_ms is not None:
        line("Stop", f"confirmed after {found.stopped.took_ms:.0f} ms")
    for problem in found.problems:
        line("!", problem)
