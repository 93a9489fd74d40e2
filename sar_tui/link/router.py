"""The clinic's router: homes and those who visit them connect to it. It runs until it is ended, and
follows the invitations meanwhile.
"""

import contextlib
import os
import threading
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import msgspec

from sar_tui.link.admission import ReportThrottle
from sar_tui.link.authority import Authority
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.listening import why_not_listening
from sar_tui.link.refusals import HOST_LOG, Refusal, RefusalLog, log_environment
from sar_tui.link.zenoh_settings import Endpoint, config, router_settings
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND

if TYPE_CHECKING:
    import zenoh

_LOOK_AGAIN_S = 2.0
_QUIET = 60 * SECOND
"""Time between two reports of the same refusal."""

Report = Callable[[str], object]


def settings_of(authority: Authority, listen: Sequence[Endpoint]) -> str:
    """Return the settings of the router as JSON, for those who are invited now: the same for
    `run_router` and for ``zenohd``. Raises LinkError.
    """
    files = authority.host_files(listen)
    made = router_settings(authority.link, listen, files, authority.guests())
    return msgspec.json.format(msgspec.json.encode(made), indent=2).decode()


def run_router(
    authority: Authority, listen: Sequence[Endpoint], report: Report, ended: threading.Event
) -> None:
    """Run the router until ``ended`` is set. When somebody is invited or revoked, or an invitation
    expires, it begins anew: connections are interrupted for a moment, and visits go on.

    It reads what Zenoh logs on this process's standard output, so ``report`` may not write there.

    Args:
        authority: of the clinic's data folder.
        listen: where it listens.
        report: told in a sentence what happens.
        ended: ends it.

    Raises:
        LinkError: it cannot listen there.
    """
    need_packages()
    refusals = _Refusals(report)
    refusals.start()
    is_first = True
    while not ended.is_set():
        settings = settings_of(authority, listen)
        refusals.begin(tuple(map(str, authority.guests())))
        with _open(settings, listen):
            if not is_first:
                report("The invitations have changed: the router has begun anew.")
            is_first = False
            while not ended.wait(_LOOK_AGAIN_S):
                with contextlib.suppress(LinkError):  # another program is writing them
                    if settings_of(authority, listen) != settings:
                        break


def _open(settings: str, listen: Sequence[Endpoint]) -> "zenoh.Session":
    import zenoh

    try:
        return zenoh.open(config(settings))
    except zenoh.ZError as error:
        raise LinkError(why_not_listening(str(error), listen, "The router")) from error


class _Refusals:
    """Reports what Zenoh refuses, from its log: see `refusals`."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._throttle: ReportThrottle[tuple[str, str, str]] = ReportThrottle(_QUIET)
        self._guests: tuple[str, ...] = ()
        self._log = RefusalLog(())

    def start(self) -> None:
        """Read standard output from here on."""
        import zenoh

        log, end = os.pipe()
        os.dup2(end, 1)
        os.close(end)
        os.environ |= log_environment(HOST_LOG)
        threading.Thread(target=self._read, args=(log,), name="router log", daemon=True).start()
        zenoh.init_log_from_env_or(HOST_LOG)

    def begin(self, guests: tuple[str, ...]) -> None:
        """Forget earlier connections: these guests may connect from now on."""
        self._guests, self._log = guests, RefusalLog(guests)

    def _read(self, log: int) -> None:
        with os.fdopen(log, encoding="utf-8", errors="replace") as lines:
            for line in lines:
                if refusal := self._log.parse(line.rstrip("\n")):
                    self._tell(refusal)

    def _tell(self, refusal: Refusal) -> None:
        if refusal.what == "message" and refusal.guest not in self._guests:
            return  # its connection was reported
        key = (refusal.guest, refusal.what, refusal.why)
        if count := self._throttle.add(key, host_now()):
            whose = f" of {refusal.guest}" if refusal.guest else ""
            times = f" ({count} times)" if count > 1 else ""
            at = datetime.now(UTC).astimezone()
            self._report(f"{at:%H:%M:%S} Refused a {refusal.what}{whose}: {refusal.why}{times}.")
