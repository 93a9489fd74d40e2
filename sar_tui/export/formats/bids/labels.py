"""Labels of BIDS file names, which have only letters and digits."""

import re
import unicodedata
from collections.abc import Iterable

from sar_tui.export.errors import ExportError


def label(text: str) -> str:
    """Return the letters and digits of a text, without accents."""
    return re.sub(r"[^0-9A-Za-z]", "", unicodedata.normalize("NFKD", text))


def labels(kind: str, prefix: str, names: Iterable[str], advice: str) -> dict[str, str]:
    """Return the labels of names, by name.

    Args:
        kind: of the names, in the plural: "Participants".
        prefix: of the label in a file name: "sub".
        advice: what to do about names that cannot be told apart.

    Raises:
        ExportError: two names would have the same label, or labels that differ only in capital
            letters, or one has no letter and no digit.
    """
    found: dict[str, str] = {}
    names_by_label: dict[str, str] = {}
    for name in names:
        found[name] = made = label(name)
        if not made:
            raise ExportError(
                f"{kind}: “{name}” has no letter or digit that BIDS takes. {advice}", bad_input=True
            )
        other = names_by_label.setdefault(made.casefold(), name)
        if other != name:
            raise ExportError(
                f"{kind} {other} and {name} would both be {prefix}-{made} in BIDS, which takes "
                "only letters and "
                f"digits. {advice}",
                bad_input=True,
            )
    return found
