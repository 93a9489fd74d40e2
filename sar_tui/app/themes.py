"""The app's themes: those to choose from, the one in use, and its edits, which are applied at once."""

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from textual.timer import Timer

from sar_tui.model.language import Language, language
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.plugins import DEFAULT_THEME, Catalogue, PluginError
from sar_tui.theme_folder import files
from sar_tui.tui.base_app import textual_theme

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui
    from sar_tui.runs.plan import Plan

LOOK_SECONDS = 0.5
"""Seconds between two looks at the files. An edited one is read once it has not changed since the
last look.
"""
_IN_FULL = 2
_ENGLISH = Language()

Stamps = tuple[tuple[Path, int, int], ...]


class Themes:
    """Chooses the theme of the app, and applies it again when it is edited.

    Args:
        app: shows its colours, and notices about it.
        catalogue: the installed themes.

    Attributes:
        known: the themes that are loaded, by name.
        used: name of the theme in use.
        watch: notices edits of it.
        pending_notice: a notice about a theme that waits until no participant sees the screen.

    Raises:
        PluginError: no theme can be read.
    """

    def __init__(self, app: "SarTui", catalogue: Catalogue) -> None:
        self._app = app
        self._catalogue = catalogue
        self.known: dict[str, Theme] = {}
        self.pending_notice = ""
        self.used = ""
        self.watch = ThemeWatch(catalogue, self._apply_edited, self._notify_editor, self._tr)
        self._looks: Timer | None = None
        self._is_looking = True
        self._use_any()

    def _use_any(self) -> None:
        """Use the default theme, or the first that can be read if a user's own of that name cannot."""
        names = dict.fromkeys((DEFAULT_THEME, *self._catalogue.theme_names()))
        for last, name in enumerate(names, 1):
            try:
                self.use_named(name)
            except PluginError:
                if last == len(names):
                    raise
            else:
                return

    def load(self) -> None:
        """Load every theme, to choose from; report one that cannot be read and load the others."""
        loaded, self.known = self.known, {}
        for name in self._catalogue.theme_names():
            try:
                theme = self.known[name] = loaded.get(name) or self._catalogue.theme(name)
            except PluginError as error:
                self._notify_editor(str(error))
            else:
                self._app.register_theme(textual_theme(theme))

    def title(self, name: str) -> str:
        """Return the title of a loaded theme, in the app's language."""
        return self._words(name)(self.known[name].title)

    def summary(self, name: str) -> str:
        """Return what a loaded theme says of itself, in the app's language."""
        return self._words(name)(self.known[name].summary)

    def _tr(self, text: str, **slots: object) -> str:
        """Translate a text into the app's language, which may change."""
        return self._app.tr(text, **slots)

    def _words(self, name: str) -> Language:
        """Return the app's language with a theme's own translations."""
        tr = self._app.tr
        return tr.including(language(tr.code, self._catalogue.theme_folder(name)).texts)

    def use_named(self, name: str) -> None:
        """Use a theme, and every edit of it. Raises PluginError."""
        self.use(self.known.get(name) or self._catalogue.theme(name), ENGLISH)

    def use_planned(self, plan: "Plan") -> None:
        """Use the theme of a planned session, if it can be read."""
        language = plan.parameters.language
        with contextlib.suppress(PluginError):
            self.use(self._catalogue.theme(plan.theme, language), language)

    def use(self, theme: Theme, language: str) -> None:
        """Use a theme that was read in a language, and every edit of it."""
        self.used = theme.name
        self.known[theme.name] = theme
        self._app.apply_theme(theme)
        self.watch.follow(theme.name, language)

    # --- edits

    def start_looking(self) -> None:
        """Look for edits from here on."""
        self._looks = self._app.set_interval(LOOK_SECONDS, self.watch.look)

    def look_for_edits(self, looks: bool) -> None:
        """Look for edits of the theme regularly, or stop looking, as before a trial."""
        if looks == self._is_looking or self._looks is None:
            return
        self._is_looking = looks
        if looks:
            self._looks.resume()
        else:
            self._looks.pause()
            self._app.clear_notifications()

    def _apply_edited(self, theme: Theme) -> None:
        self.pending_notice = ""
        self.known[theme.name] = theme
        self._app.apply_theme(theme)
        live = self._app.open_session
        if live and live.session.theme.name == theme.name:
            live.session.apply_theme(theme)

    def _notify_editor(self, text: str) -> None:
        """Notify the editor of a theme; during a session, wait until the participant has left."""
        if self._app.has_participant:
            self.pending_notice = text
        else:
            self._app.notify(text, severity="warning", timeout=15, markup=False)

    def show_pending_notice(self) -> None:
        """Show the notice that waited, unless a participant is still there."""
        if text := self.pending_notice:
            self.pending_notice = ""
            self._notify_editor(text)


class ThemeWatch:
    """Follows the files of one theme. It has no timer: the app calls ``look``, never during a
    trial.

    Args:
        catalogue: finds and reads themes.
        apply: called with an edited theme.
        notify: called with one or two sentences for the editor if the theme, or a part of it,
            cannot be read.
        tr: translates them.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        apply: Callable[[Theme], object],
        notify: Callable[[str], object],
        tr: Callable[..., str] = _ENGLISH,
    ) -> None:
        self._catalogue = catalogue
        self._apply = apply
        self._notify = notify
        self._tr = tr
        self._name, self._language = "", ENGLISH
        self._known: Stamps = ()
        self._last: Stamps = ()

    def follow(self, name: str, language: str = ENGLISH) -> None:
        """Follow this theme in this language from here on."""
        self._name, self._language = name, language
        self._known = self._last = self._stamps()

    def look(self) -> None:
        """Read the theme again if its files have changed, but not since the last look."""
        tr, stamps = self._tr, self._stamps()
        is_settled, self._last = stamps == self._last, stamps
        if stamps == self._known or not is_settled:
            return
        self._known = stamps
        try:
            theme = self._catalogue.theme(self._name, self._language)
        except (PluginError, OSError, ValueError) as error:
            why = str(error)
            if not isinstance(error, PluginError):  # its folder cannot be searched
                why = tr("The theme {name} cannot be read: {why}.", name=self._name, why=why)
            self._notify(f"{why} {tr('The previous version stays in use.')}")
            return
        self._apply(theme)
        if theme.repairs:
            self._notify(_repairs_notice(theme.repairs, tr))

    def _stamps(self) -> Stamps:
        """Return the theme's files with their times of change and sizes."""
        try:
            found = [
                (path, path.stat()) for path in files(self._catalogue.theme_folder(self._name))
            ]
        except (OSError, ValueError, PluginError):  # an editor is replacing a file
            return ()
        return tuple((path, status.st_mtime_ns, status.st_size) for path, status in found)


def _repairs_notice(repairs: tuple[str, ...], tr: Callable[..., str]) -> str:
    """Return a notice of the problems of a theme that could be read; the first ones in full."""
    count, first = len(repairs), " ".join(repairs[:_IN_FULL])
    said = [
        tr("Theme edited. One thing to fix: {what}", what=first)
        if count == 1
        else tr("Theme edited. {count} things to fix: {what}", count=count, what=first)
    ]
    if count > _IN_FULL:
        said.append(tr("And {count} more: see sar-tui themes check.", count=count - _IN_FULL))
    return " ".join(said)
