"""The operator's panel, offered while a session of this data folder can be joined."""

from typing import Any

from textual.screen import Screen


class JoiningScreen(Screen[None]):
    """The part of the first screen that opens the operator's panel."""

    app: Any
    _can_operate = False

    def look_for_sessions(self) -> None:
        """Offer the panel while a session of this data folder can be joined."""
        from sar_tui.link.discovery import joinable_sessions
        from sar_tui.link.errors import LinkError

        if not self.is_current:
            return
        try:
            can_operate = bool(joinable_sessions(self.app.folder))
        except LinkError:
            can_operate = False
        if can_operate != self._can_operate:
            self._can_operate = can_operate
            self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        return (
            self._can_operate if action == "operate" else super().check_action(action, parameters)
        )

    def action_operate(self) -> None:
        """Choose a session, and open its panel."""
        from sar_tui.link.discovery import JoinableSession, joinable_sessions
        from sar_tui.operator.session_picker import ChooseScreen, own_name, panel

        def chosen(live: JoinableSession | None) -> None:
            if live is not None:
                theme = next(iter(self.app.themes.known.values()))
                self.app.push_screen(
                    panel(live, own_name(), "operator", theme, self.app.folder), left
                )

        def left(why: str | None) -> None:
            if why:
                self.notify(why, severity="warning", timeout=15)

        found = joinable_sessions(self.app.folder)
        if len(found) == 1:
            chosen(found[0])
        else:
            self.app.push_screen(ChooseScreen(self.app.folder), chosen)
