"""What the panel asks before it does something that cannot be taken back, or is not an operator's alone."""

from sar_tui.operator import key_help, status_view
from sar_tui.operator.own_file import KeymapFile
from sar_tui.operator.session_state import SessionState

_ASKED = {
    "end": "End the session? {key} again ends it, Esc lets it go on.",
    "close": "Leave the panel? {key} again leaves it, Esc stays. The session goes on.",
    "resume": "{why}. {key} again, within 3 s, lets it go on.",
}
_KEY_OF = {"resume": "pause"}


def question(what: str, mirror: SessionState, file: KeymapFile) -> str:
    """The words, with the key that says yes; empty where nothing is asked, or no longer needs to be."""
    if not what or (what == "resume" and not mirror.is_their_pause):
        return ""
    return _ASKED[what].format(key=key_help.key_of(_KEY_OF.get(what, what), file), why=status_view.waits(mirror))
