"""The return from a session: questions after it, what went wrong in it, and the screen that
follows.
"""

from sar_tui.app.beginning import BeginningApp
from sar_tui.app.exit_message import UNSAVED
from sar_tui.store.database import StoreError, connect


class EndingApp(BeginningApp):
    """The part of the app that closes a session, and tells what became of it."""

    def _session_left(self, _: object) -> None:
        """Close the session once its screen is gone: after its summary, or because the task
        failed.
        """
        self.close_session()
        self.look_for_edits(True)
        live = self.live
        if self.failure or live is None or not live.asks_after:
            self._return_home()
            return
        from sar_tui.app import wellbeing

        def answered(_: bool | None) -> None:
            self._is_asking = False
            self._return_home()
            for text in wellbeing.warnings(self, list(live.codes.values())):
                if self.patient:
                    self.note_trouble(text)
                else:
                    self.notify(text, severity="warning", timeout=60)

        self.check_database()
        self._is_asking = True
        self.push_screen(wellbeing.ask_after(self, live), answered)

    def _return_home(self) -> None:
        """Return to the home screen, or exit if the app was opened for one session."""
        if self.patient:
            self._patient_left()
            return
        if self._begin is not None or self.failure:
            self.exit(return_code=1 if self.failure else 0)
            return
        self._show_pending_notice()
        self.check_database()
        if self.live and self.live.rescued:
            self.notify(
                f"{self.live.rescued} `sar-tui rescue` brings it back.",
                severity="error",
                timeout=60,
            )
        if self.live and self.live.unsaved:
            self.notify(
                f"{UNSAVED} Free some space before the next session.", severity="error", timeout=30
            )

        if self.live and self.live.trouble:
            self.notify(self.live.trouble, severity="error", timeout=30)
            self.live.trouble = ""

    def _patient_left(self) -> None:
        """Keep what went wrong for the therapist, and go on to the participant's next exercise."""
        assert self.live
        if self.failure:
            self.note_trouble(self.failure)
            self.failure = ""
        if self.live.rescued:
            self.note_trouble(f"{self.live.rescued} `sar-tui rescue` brings it back.")
        if self.live.unsaved:
            self.note_trouble(UNSAVED)
        if self.live.trouble:
            self.note_trouble(self.live.trouble)
        self.check_database()
        self._exercise_left(ended=self.live.run.session.ended, is_mistake=self.live.is_mistake)
        from sar_tui.app import wellbeing

        if self.live.run.session.ended and wellbeing.had_better_rest(self, self.live):
            self._stopped_by_pain()

    def close_session(self) -> None:
        """Close the live session and its workers, if there is one, and stop sensors that are being
        checked.
        """
        self._stop_feeds()
        if self.live:
            self.live.close(self)
        self._own_link.close()

    def check_database(self) -> None:
        """Open the database anew if its files were removed or replaced, and say so."""
        try:
            self.database.check()
        except StoreError as error:
            self.database.close()
            self.database = connect(self.folder)
            if self.patient:
                self.note_trouble(str(error))
            else:
                self.notify(str(error), severity="error", timeout=60)

    def tell_troubles(self) -> None:
        """Say if rescue files wait, or data was lost."""
        from sar_tui.store.troubles import troubles

        for text in troubles(self.database, self.folder):
            self.notify(text, severity="error", timeout=60)
