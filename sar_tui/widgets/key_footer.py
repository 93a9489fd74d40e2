"""Footer that lists the keys of a screen."""

from textual.app import ComposeResult
from textual.screen import Screen
from textual.widgets import Footer
from textual.widgets._footer import FooterKey

from sar_tui.widgets.language import language_of


class KeyFooter(Footer):
    """Textual's footer in the language of the screen, composed anew only when its keys change.

    Textual composes it whenever the focus moves, which takes longer than everything else that a key
    press does.

    Args:
        for_participant: leaves out the keys of a therapist, which F1 names: to leave the app, and
            everything by name.
    """

    _keys: tuple[tuple[object, ...], ...] | None = None

    def __init__(self, *, for_participant: bool = False, show_command_palette: bool = True) -> None:
        super().__init__(show_command_palette=show_command_palette and not for_participant)
        self.for_participant = for_participant

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        for part in super().compose():
            if isinstance(part, FooterKey):
                if self.for_participant and part.action == "quit":
                    continue
                part.description = tr(part.description)
                if not part.has_class("-command-palette"):
                    # otherwise each key is styled as compact, its default, and then again
                    part.set_reactive(FooterKey.compact, self.compact)
            yield part

    def bindings_changed(self, screen: Screen[object]) -> None:
        """Compose the keys anew if they differ from those shown."""
        keys = tuple(
            (binding.key, binding.description, binding.action, binding.group, enabled)
            for _, binding, enabled, _ in screen.active_bindings.values()
            if binding.show
        )
        if keys != self._keys:
            super().bindings_changed(screen)
            is_composed = self.is_attached and screen is self.screen and self.app.app_focus
            self._keys = keys if is_composed else None
