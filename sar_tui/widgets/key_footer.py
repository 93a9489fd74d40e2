"""Footer that lists the keys of a screen."""

from collections.abc import Sequence

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Footer
from textual.widgets._footer import FooterKey

from sar_tui.widgets.language import language_of


class KeyFooter(Footer):
    """Textual's footer in the language of the screen, with the way back first, composed anew only when its keys change.

    Textual composes it whenever the focus moves, which takes longer than everything else that a key
    press does.

    Args:
        for_participant: leaves out the keys of a therapist, which F1 names: to leave the app, and
            everything by name.
        optional: actions whose keys are left out where there is no room for all, the first ones
            first. F1 names them.
    """

    _keys: tuple[tuple[object, ...], ...] | None = None

    def __init__(
        self,
        *,
        for_participant: bool = False,
        show_command_palette: bool = True,
        optional: Sequence[str] = (),
    ) -> None:
        super().__init__(show_command_palette=show_command_palette and not for_participant)
        self.for_participant = for_participant
        self.optional = optional

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        parts = []
        for part in super().compose():
            if isinstance(part, FooterKey):
                if self.for_participant and part.action == "quit":
                    continue
                part.description = tr(part.description)
                if not part.has_class("-command-palette"):
                    # otherwise each key is styled as compact, its default, and then again
                    part.set_reactive(FooterKey.compact, self.compact)
            parts.append(part)
        parts.sort(key=lambda part: not isinstance(part, FooterKey) or part.key != "escape")
        yield from self._fitting(parts)

    def _fitting(self, parts: list[Widget]) -> list[Widget]:
        """Return the parts without the optional keys that there is no room for."""
        wide = {part: _width(part) for part in parts if isinstance(part, FooterKey)}
        for action in self.optional:
            if sum(wide.values()) > self.app.size.width:
                wide = {part: width for part, width in wide.items() if part.action != action}
        return [part for part in parts if not isinstance(part, FooterKey) or part in wide]

    def bindings_changed(self, screen: Screen[object]) -> None:
        """Compose the keys anew if they differ from those shown."""
        keys: tuple[tuple[object, ...], ...] = tuple(
            (binding.key, binding.description, binding.action, binding.group, enabled)
            for _, binding, enabled, _ in screen.active_bindings.values()
            if binding.show
        )
        if self.optional:
            keys += ((self.app.size.width,),)
        if keys != self._keys:
            super().bindings_changed(screen)
            is_composed = self.is_attached and screen is self.screen and self.app.app_focus
            self._keys = keys if is_composed else None


def _width(key: FooterKey) -> int:
    """Return the columns of a key with its description and the blanks around them."""
    return cell_len(f" {key.key_display} {key.description} ")
