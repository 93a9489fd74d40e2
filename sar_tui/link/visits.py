"""Live visits: a home dials out to the clinic's router, and a therapist there visits it.

The home's invitation is in its data folder. A session at home connects to the router as a client,
in the broker process, and opens no port. The participant is asked before anything of the session is
sent.
"""

import contextlib
import itertools
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.files import make_private
from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.invitation import Invitation, home_file, read, write
from sar_tui.link.protocol import Setup
from sar_tui.link.zenoh_settings import LinkKeys, config, home_link, network_settings
from sar_tui.model.units import MS

_RETRY_S = 2.0


class HomeVisit(NamedTuple):
    """A home that an operator or observer visits through a router, by their invitation."""

    invitation: Invitation
    home: str


# --- at home


def keep_home(data: Path, file: Path) -> Invitation:
    """Keep a home's invitation in the data folder, in place of an earlier one. Raises LinkError if
    it is not valid, not for a home, or cannot be written.
    """
    invitation = read(file)
    if invitation.role != "home":
        raise LinkError(
            f"{file} invites an {invitation.role}. To dial out, a home needs an invitation made by "
            "`sar-tui link invite home`."
        )
    kept = home_file(data)
    new = kept.with_suffix(f".{os.getpid()}")
    try:
        make_private(kept.parent)
        write(invitation, new)
        new.replace(kept)
    except OSError as error:
        raise LinkError(f"{kept} cannot be written: {error.strerror}.") from None
    return invitation


def remove_home(data: Path) -> bool:
    """Remove the invitation, so that no session dials out; False if there is none."""
    try:
        home_file(data).unlink()
    except FileNotFoundError:
        return False
    except OSError as error:
        raise LinkError(f"{home_file(data)} cannot be removed: {error.strerror}.") from None
    return True


@contextlib.contextmanager
def open_visits(data: Path, lost_ms: int) -> Iterator[BrokerProcess]:
    """Let a session dial out to the clinic's router for the duration of the block. It does not wait
    for the router.

    Args:
        data: the data folder, which has a home's invitation.
        lost_ms: silence after which a visitor is lost (ms).

    Raises:
        LinkError: the invitation cannot be used, or the process cannot be started.
    """
    need_packages()
    invitation = read(home_file(data), is_known=True)
    dials = tuple(
        network_settings(where, invitation.credentials, through_router=True)
        for where in invitation.where
    )
    link = home_link(invitation.link, invitation.name)
    broker = BrokerProcess(Setup("", link, lost_ms * MS, dials=dials))
    broker.open()
    try:
        yield broker
    finally:
        broker.close()


# --- at the clinic


class HomeFinder:
    """Finds the homes where somebody is training, through a router. Everything runs on threads.

    Args:
        invitation: of an operator or observer.
        on_change: called on any thread when ``homes`` or ``why`` has changed.

    Attributes:
        homes: names of the homes that are there.
        why: why the router cannot be reached; empty if it is, or as long as that is not known.
    """

    def __init__(self, invitation: Invitation, on_change: Callable[[], object]) -> None:
        self._invitation, self._on_change = invitation, on_change
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self.homes: tuple[str, ...] = ()
        self.why = ""
        self._thread = threading.Thread(target=self._run, name="home finder", daemon=True)

    def open(self) -> None:
        """Begin to look."""
        self._thread.start()

    def close(self) -> None:
        """Stop looking."""
        self._closed.set()

    def _run(self) -> None:
        import zenoh

        from sar_tui.link.client import probe

        invitation = self._invitation
        keys = LinkKeys(home_link(invitation.link, "*"))
        for where in itertools.cycle(invitation.where):
            if self._closed.is_set():
                return
            settings = network_settings(where, invitation.credentials, through_router=True)
            try:
                session = zenoh.open(config(settings))
            except zenoh.ZError:
                try:
                    probe(settings, f"{invitation.link}/-")
                except LinkError as error:
                    self._tell(str(error))
                self._closed.wait(_RETRY_S)
                continue
            with session:
                self._tell("")
                handler = zenoh.handlers.Callback(self._seen, indirect=False)
                watched = session.liveliness().declare_subscriber(
                    keys.broadcast, handler, history=True
                )
                self._closed.wait()
                watched.undeclare()  # type: ignore[no-untyped-call]
            return

    def _tell(self, why: str) -> None:
        if why != self.why:
            self.why = why
            self._on_change()

    def _seen(self, sample: object) -> None:
        """Handle that a home appeared or disappeared."""
        key, kind = str(sample.key_expr), str(sample.kind)  # type: ignore[attr-defined]
        name = key.split("/")[-2]
        with self._lock:
            others = [home for home in self.homes if home != name]
            self.homes = tuple(sorted(others if "DELETE" in kind else [*others, name]))
        self._on_change()
