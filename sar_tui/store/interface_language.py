"""The language of the screens for therapists and operators: that of the computer, or one that was
chosen for a data folder.

Participants' screens are in the language of their sessions, which is a setting.
"""

import os
import re
from collections.abc import Mapping
from pathlib import Path

from sar_tui.drivers.files import write_private
from sar_tui.model.language import BUNDLED, Language

FILE = "interface-language"
"""Holds the code of the language, if one was chosen."""
_LOCALE = ("LC_ALL", "LC_MESSAGES", "LANG")
"""Environment variables of POSIX, the strongest first. Windows sets none of them."""


def interface_language(folder: Path, environment: Mapping[str, str] = os.environ) -> str:
    """Return the code of the language that was chosen for a data folder, else that of the computer;
    English if it is not bundled.
    """
    try:
        chosen = (folder / FILE).read_text(encoding="utf-8").strip()
    except (OSError, ValueError):
        chosen = ""
    return chosen if chosen in BUNDLED else _of_computer(environment)


def choose_interface_language(folder: Path, code: str) -> None:
    """Keep a language for a data folder. Raises OSError if it cannot be written."""
    path = folder / FILE
    new = path.with_suffix(".new")
    new.unlink(missing_ok=True)
    write_private(new, f"{code}\n")
    new.replace(path)


def _of_computer(environment: Mapping[str, str]) -> str:
    locale = next((environment[name] for name in _LOCALE if environment.get(name)), "")
    code = re.split(r"[_.@-]", locale)[0].lower()
    return code if code in BUNDLED else Language().code
