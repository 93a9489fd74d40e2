"""What the app wears: the themes there are, the one that is worn, and its edits."""

from typing import TYPE_CHECKING

from textual.app import App
from textual.timer import Timer

from sar_tui.app.theme_watch import LOOK_SECONDS, ThemeWatch
from sar_tui.framework.theme import ENGLISH, Theme
from sar_tui.plugins import DEFAULT_THEME, Catalogue, PluginError
from sar_tui.tui.textual_theme import textual_theme

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession


class ThemedApp(App[int]):
    """The part of the app that themes are: chosen, worn, and worn anew when they are edited.

    Args:
        catalogue: the tasks and themes there are.

    Raises:
        PluginError: no theme can be read.
    """

    if TYPE_CHECKING:  # what the whole app knows

        @property
        def _open(self) -> "LiveSession | None":
            """The session that is open."""

        @property
        def _seats_participant(self) -> bool:
            """Whether a participant sits in front of the screen."""

    _edits: Timer

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__()
        self.catalogue = catalogue
        self.themes: dict[str, Theme] = {}
        self.untold = ""
        self.theme_watch = ThemeWatch(catalogue, self._wear_edited, self._tell_editor)
        self._looks = True
        self._wear_any()

    def look_after_themes(self) -> None:
        """Look for edits from here on."""
        self._edits = self.set_interval(LOOK_SECONDS, self.theme_watch.look)

    def load_themes(self) -> None:
        """Have every theme to choose. One that cannot be read is told, and keeps nobody from the others."""
        worn, self.themes = self.themes, {}
        for name in self.catalogue.theme_names():
            try:
                theme = self.themes[name] = worn.get(name) or self.catalogue.theme(name)
            except PluginError as error:
                self._tell_editor(str(error))
            else:
                self.register_theme(textual_theme(theme))

    def _wear_any(self) -> None:
        """Wear the default theme; where somebody's own has taken its name and cannot be read, the first that can."""
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
        """Wear a theme of the Social-Behavioral Base, and every edit of it. Raises PluginError."""
        self._wear(self.themes.get(name) or self.catalogue.theme(name), ENGLISH)

    def _wear(self, theme: Theme, language: str) -> None:
        self.themes[theme.name] = theme
        self._put_on(theme)
        self.theme = f"sar-{theme.name}"
        self.theme_watch.follow(theme.name, language)

    def _put_on(self, theme: Theme) -> None:
        """Have the colours of a theme; show them, if it is the one that is worn."""
        anew = textual_theme(theme)
        if self.available_themes.get(anew.name) == anew:
            return
        self.register_theme(anew)
        if self.theme == anew.name:
            self.mutate_reactive(App.theme)

    def look_for_edits(self, looks: bool) -> None:
        """Look now and then whether the theme was edited; or not, because a trial is about to begin."""
        if looks != self._looks:
            self._looks = looks
            if looks:
                self._edits.resume()
            else:
                self._edits.pause()
                self.clear_notifications()

    def _wear_edited(self, theme: Theme) -> None:
        self.untold = ""
        self.themes[theme.name] = theme
        self._put_on(theme)
        if self._open and self._open.run.session.theme.name == theme.name:
            self._open.run.session.wear(theme)

    def _tell_editor(self, words: str) -> None:
        """Tell whoever edits a theme; but not on the screen of a participant, where it is told when they have gone."""
        if self._seats_participant:
            self.untold = words
        else:
            self.notify(words, severity="warning", timeout=15, markup=False)

    def _tell_what_waited(self) -> None:
        if words := self.untold:
            self.untold = ""
            self._tell_editor(words)
