"""The check of the letterbox: who writes letters here, and whether they go through."""

from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.finding import Finding, Machine, bad, care, not_installed, ok
from sar_tui.drivers.installation import pip_install_extra

if TYPE_CHECKING:
    from sar_tui.letterbox.identity import Identity
    from sar_tui.letterbox.status import Clinic, Home


def letterbox(here: Machine) -> Finding:
    """Check whether letters between a clinic and homes can be exchanged, and which are missing."""
    from sar_tui.letterbox.identity import read
    from sar_tui.store.database import StoreError

    try:
        me = read(here.home.folder)
    except StoreError as error:
        return bad(str(error), "Bring the file back from where it was saved, or invite again.")
    if find_spec("nacl") is None:
        how = pip_install_extra("letterbox")
        if me is None:
            return not_installed(how, "Only `sar-tui letterbox` needs it.")
        return bad("PyNaCl is not installed: no letter can be read or written.", f"Run: {how}")
    if me is None:
        return ok("none: nobody trains at home, and this is no home")
    return _letters(here.home.folder, me)


def _letters(data: Path, me: "Identity") -> Finding:
    """Look at the letterbox, and at what is stored of the letters."""
    from sar_tui.letterbox import status
    from sar_tui.letterbox.folder import Letterbox
    from sar_tui.store.database import StoreError, connect_to_read

    try:
        Letterbox(Path(me.folder))
        with closing(connect_to_read(data)) as database:
            if me.is_home:
                return _home(me, status.clinic(database))
            return _clinic(me, status.homes(database))
    except StoreError as error:
        return care(str(error))


def _clinic(me: "Identity", homes: "list[Home]") -> Finding:
    joined = [each for each in homes if each.state == "joined"]
    invited = sum(each.state == "invited" for each in homes)
    found = (
        f"the clinic {me.clinic}, in {me.folder}; homes: {len(joined)} joined, {invited} invited"
    )
    missing = [each.name for each in joined if each.missing]
    if missing:
        return care(
            f"{found}; letters of {', '.join(missing)} are missing",
            "They are asked for again, which takes an exchange on both sides. "
            "`sar-tui letterbox list` shows which.",
        )
    return ok(found)


def _home(me: "Identity", clinic: "Clinic | None") -> Finding:
    found = f"{me.participant} trains at home for {me.clinic}, in {me.folder}"
    if clinic is None or not clinic.heard_at:
        return ok(f"{found}; nothing was heard of the clinic yet")
    found = f"{found}; heard of the clinic on {clinic.heard_at[:10]}"
    if clinic.waiting:
        found = f"{found}; letters that it has not acknowledged yet: {clinic.waiting}"
    if clinic.state != "joined":
        return care(
            f"{found}; the clinic takes no letters from here", "Ask it for a new invitation."
        )
    if clinic.missing:
        return care(f"{found}; {len(clinic.missing)} missing", "They are asked for again.")
    return ok(found)
