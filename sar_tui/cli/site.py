"""``sar-tui site``: the site of the recorded data."""

from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, print_json


def site(
    context: typer.Context,
    code: Annotated[
        str | None,
        typer.Argument(metavar="CODE", help="The site's code, such as BERN.", show_default=False),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the code of this site, or set it. All that was recorded here belongs to it."""
    from sar_tui.store import sites

    home = Home.of(context, data, tasks)
    if code is not None:
        code = sites.check_site(code)
        with home.writable_database() as database:
            before, now = sites.own(database), sites.set_own(database, code)
    else:
        with home.database() as database:
            before = now = sites.own(database)
    if as_json:
        print_json({"site": now})
    elif not now:
        print("This site has no code. Set it, for example to BERN: sar-tui site BERN")
    else:
        print(f"All that was recorded in {home.folder} belongs to the site {now}.")
        if before not in ("", now):
            print(
                f"It was {before}: whoever has data of {before} already must get it again, and "
                "remove the earlier."
            )
