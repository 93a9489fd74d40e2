"""A session's pause: when there can be one, its menu, and the therapist's changes behind it."""

from typing import ClassVar

from textual.binding import Binding, BindingType

from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.session_message import MessageScreen
from sar_tui.model.messages import SessionCommand, StepEnded


class PausingScreen(MessageScreen):
    """The part of a session's screen that pauses the session, and asks what then."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "pause", "Pause", id="pause")]

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Offer a pause if there is something to pause, and its menu while a sensor is awaited."""
        waiting = self._waiting
        if action != "pause" or waiting is None:
            return action != "pause"
        return waiting.what == "sensor" or waiting.stage not in ("paused", "ended")

    def action_pause(self) -> None:
        """Pause at once, without a question."""
        self._live.operate(SessionCommand(command="pause"))

    @property
    def is_in_trial(self) -> bool:
        """True in a trial, which is paused when another screen covers this one."""
        return self._waiting is not None and self._waiting.stage == "trial"

    def on_screen_suspend(self) -> None:
        """Pause a trial that another screen covers: the participant cannot see the prompt."""
        if self.is_in_trial:
            self.action_pause()

    def on_pause_menu_chosen(self, event: PauseMenu.Chosen) -> None:
        self._live.is_mistake = event.act.command == "end" and event.act.reason == "mistake"
        self._live.operate(event.act)
        if event.act.reason == "pain" and self._live.run.session.task.parameters.ask_wellbeing:
            from sar_tui.app.wellbeing import ask_after

            self.app.push_screen(ask_after(self.app, self._live, "pause"), self._told_of_pain)

    def step_ended(self, ended: StepEnded) -> None:
        """Pause after too much pain in an answer between attempts, and advise to stop."""
        from sar_tui.app.wellbeing import advise

        if question := advise(self.app, self._live, ended):
            self._live.operate(SessionCommand(command="pause", reason="pain", seat=ended.seat))
            self.app.push_screen(question, self._told_of_pain)

    def _told_of_pain(self, goes_on: bool | None) -> None:
        """End the session if the participant follows the advice not to go on."""
        if goes_on is False:
            self._live.operate(SessionCommand(command="end", reason="finished"))

    def on_pause_menu_therapist_asked(self) -> None:
        """Open the therapist's changes, behind the passphrase if there is one."""
        from sar_tui.app.screens.adjust import AdjustScreen
        from sar_tui.app.screens.passphrase import PassphraseScreen

        def entered(is_right: bool | None) -> None:
            if is_right and self._waiting and self._waiting.stage == "paused":
                self.app.push_screen(AdjustScreen(self._live))

        if self.app.patient_mode.passphrase.is_set:
            self.app.push_screen(
                PassphraseScreen(self.app.patient_mode.passphrase, "pause"), entered
            )
        else:
            entered(True)
