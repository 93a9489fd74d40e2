"""Notices that the active theme was edited, and reads it again."""

from collections.abc import Callable
from pathlib import Path

from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.theme_folder import files

LOOK_SECONDS = 0.5
"""Seconds between two looks at the files. An edited one is read once it has not changed since the
last look.
"""
_IN_FULL = 2

Stamps = tuple[tuple[Path, int, int], ...]


class ThemeWatch:
    """Follows the files of one theme. It has no timer: the app calls ``look``, never during a
    trial.

    Args:
        catalogue: finds and reads themes.
        apply: called with an edited theme.
        notify: called with one or two sentences for the editor if the theme, or a part of it,
            cannot be read.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        apply: Callable[[Theme], object],
        notify: Callable[[str], object],
    ) -> None:
        self._catalogue = catalogue
        self._apply = apply
        self._notify = notify
        self._name, self._language = "", ENGLISH
        self._known: Stamps = ()
        self._last: Stamps = ()

    def follow(self, name: str, language: str = ENGLISH) -> None:
        """Follow this theme in this language from here on."""
        self._name, self._language = name, language
        self._known = self._last = self._stamps()

    def look(self) -> None:
        """Read the theme again if its files have changed, but not since the last look."""
        stamps = self._stamps()
        is_settled, self._last = stamps == self._last, stamps
        if stamps == self._known or not is_settled:
            return
        self._known = stamps
        try:
            theme = self._catalogue.theme(self._name, self._language)
        except PluginError as error:
            self._notify(f"{error} The previous version stays in use.")
            return
        except (OSError, ValueError) as error:  # its folder cannot be searched
            self._notify(
                f"The theme {self._name} cannot be read: {error}. The previous version stays in "
                "use."
            )
            return
        self._apply(theme)
        if theme.repairs:
            self._notify(_repairs_notice(theme.repairs))

    def _stamps(self) -> Stamps:
        """Return the theme's files with their times of change and sizes."""
        try:
            found = [
                (path, path.stat()) for path in files(self._catalogue.theme_folder(self._name))
            ]
        except (OSError, ValueError, PluginError):  # an editor is replacing a file
            return ()
        return tuple((path, status.st_mtime_ns, status.st_size) for path, status in found)


def _repairs_notice(repairs: tuple[str, ...]) -> str:
    """Return a notice of the problems of a theme that could be read; the first ones in full."""
    count = "One thing" if len(repairs) == 1 else f"{len(repairs)} things"
    more = (
        f" And {len(repairs) - _IN_FULL} more: see sar-tui themes check."
        if len(repairs) > _IN_FULL
        else ""
    )
    return f"Theme edited. {count} to fix: {' '.join(repairs[:_IN_FULL])}{more}"
