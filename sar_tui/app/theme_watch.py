"""Notices that the theme that is worn has been edited, and reads it again."""

from collections.abc import Callable
from pathlib import Path

from sar_tui.framework.theme import ENGLISH, Theme
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.theme_folder import files

LOOK_SECONDS = 0.5
"""How often files are looked at. One that has just changed is read when it has come to rest, a look later."""
_TOLD = 2

Stamps = tuple[tuple[Path, int, int], ...]


class ThemeWatch:
    """Follows the files of one theme. It has no timer of its own: ``look`` is called, and never in a trial.

    Args:
        catalogue: finds and reads themes.
        wear: called with a theme that was edited.
        tell: called with one or two sentences for whoever edits it, where it cannot be read, or not all of it.
    """

    def __init__(self, catalogue: Catalogue, wear: Callable[[Theme], object], tell: Callable[[str], object]) -> None:
        self._catalogue = catalogue
        self._wear = wear
        self._tell = tell
        self._name, self._language = "", ENGLISH
        self._known: Stamps = ()
        self._last: Stamps = ()

    def follow(self, name: str, language: str = ENGLISH) -> None:
        """Follow this theme from here on, in a language."""
        self._name, self._language = name, language
        self._known = self._last = self._stamps()

    def look(self) -> None:
        """Read the theme anew if its files have changed, and then changed no more since the last look."""
        stamps = self._stamps()
        has_come_to_rest, self._last = stamps == self._last, stamps
        if stamps == self._known or not has_come_to_rest:
            return
        self._known = stamps
        try:
            theme = self._catalogue.theme(self._name, self._language)
        except PluginError as error:
            self._tell(f"{error} It looks and speaks as it did before.")
            return
        except (OSError, ValueError) as error:  # its folder cannot even be looked for
            self._tell(f"The theme {self._name} cannot be read: {error}. It looks and speaks as it did before.")
            return
        self._wear(theme)
        if theme.repairs:
            self._tell(_repairs_notice(theme.repairs))

    def _stamps(self) -> Stamps:
        """Which files there are, when they were changed, and how long they are."""
        try:
            found = [(path, path.stat()) for path in files(self._catalogue.theme_folder(self._name))]
        except (OSError, ValueError, PluginError):  # an editor is putting one in the place of another
            return ()
        return tuple((path, status.st_mtime_ns, status.st_size) for path, status in found)


def _repairs_notice(repairs: tuple[str, ...]) -> str:
    """What is wrong with a theme that could be read; the first of it in its own words."""
    count = "One thing" if len(repairs) == 1 else f"{len(repairs)} things"
    more = f" And {len(repairs) - _TOLD} more: see sar-tui themes check." if len(repairs) > _TOLD else ""
    return f"Theme edited. {count} to fix: {' '.join(repairs[:_TOLD])}{more}"
