"""The app's themes: the available ones, the active one, and edits of it."""

from typing import TYPE_CHECKING

from textual.timer import Timer

from sar_tui.app.theme_watch import LOOK_SECONDS, ThemeWatch
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.plugins import DEFAULT_THEME, Catalogue, PluginError
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.textual_theme import textual_theme

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession


class ThemedApp(BaseApp):
    """The part of the app that chooses themes, and applies them again when they are edited.

    Args:
        catalogue: the installed tasks and themes.

    Attributes:
        pending_notice: a notice about an edited theme that waits until no participant sees the
            screen.

    Raises:
        PluginError: no theme can be read.
    """

    if TYPE_CHECKING:  # defined by the whole app

        @property
        def _open(self) -> "LiveSession | None":
            """The session that is open."""

        @property
        def _has_participant(self) -> bool:
            """True while a participant sits in front of the screen."""

    _edits: Timer

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__()
        self.catalogue = catalogue
        self.themes: dict[str, Theme] = {}
        self.pending_notice = ""
        self.theme_watch = ThemeWatch(catalogue, self._apply_edited, self._notify_editor)
        self._looks_for_edits = True
        self._use_any_theme()

    def watch_themes(self) -> None:
        """Look for edits from here on."""
        self._edits = self.set_interval(LOOK_SECONDS, self.theme_watch.look)

    def load_themes(self) -> None:
        """Load every theme, to choose from; report one that cannot be read and load the others."""
        loaded, self.themes = self.themes, {}
        for name in self.catalogue.theme_names():
            try:
                theme = self.themes[name] = loaded.get(name) or self.catalogue.theme(name)
            except PluginError as error:
                self._notify_editor(str(error))
            else:
                self.register_theme(textual_theme(theme))

    def _use_any_theme(self) -> None:
        """Use the default theme; if a user's own of that name cannot be read, the first that
        can.
        """
        names = dict.fromkeys((DEFAULT_THEME, *self.catalogue.theme_names()))
        for last, name in enumerate(names, 1):
            try:
                self.use_theme(name)
            except PluginError:
                if last == len(names):
                    raise
            else:
                return

    def use_theme(self, name: str) -> None:
        """Use a theme, and every edit of it. Raises PluginError."""
        self._use(self.themes.get(name) or self.catalogue.theme(name), ENGLISH)

    def _use(self, theme: Theme, language: str) -> None:
        self.themes[theme.name] = theme
        self.apply_theme(theme)
        self.theme_watch.follow(theme.name, language)

    def look_for_edits(self, looks: bool) -> None:
        """Look for edits of the theme regularly, or stop looking, as before a trial."""
        if looks != self._looks_for_edits:
            self._looks_for_edits = looks
            if looks:
                self._edits.resume()
            else:
                self._edits.pause()
                self.clear_notifications()

    def _apply_edited(self, theme: Theme) -> None:
        self.pending_notice = ""
        self.themes[theme.name] = theme
        self.apply_theme(theme)
        if self._open and self._open.run.session.theme.name == theme.name:
            self._open.run.session.apply_theme(theme)

    def _notify_editor(self, text: str) -> None:
        """Notify the editor of a theme; during a session, wait until the participant has left."""
        if self._has_participant:
            self.pending_notice = text
        else:
            self.notify(text, severity="warning", timeout=15, markup=False)

    def _show_pending_notice(self) -> None:
        if text := self.pending_notice:
            self.pending_notice = ""
            self._notify_editor(text)
