"""Probes whether a session admits a guest, in a child process whose output contains Zenoh's log of
a refusal.
"""

import os
import subprocess
import sys

from sar_tui.drivers import child_process
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.refusals import GUEST_LOG, log_environment, why_not_connected

_TIMEOUT_S = 10.0
_ANSWER_TIMEOUT_S = 2.0
_CONNECTED, _ADMITTED = "connected", "admitted"
NOT_ADMITTED = (
    "The session there does not accept this invitation: it was revoked, or made after that "
    "session began. Ask for a "
    "new one, or have the session restarted."
)


def probe(settings: str, link: str) -> None:
    """Connect once to a link with a guest's Zenoh settings. Takes up to ten seconds.

    Raises:
        LinkError: the session does not admit the guest; the message says why, as far as is known.
    """
    need_packages()
    with subprocess.Popen(
        child_process.python("sar_tui.link.probe"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **log_environment(GUEST_LOG)},
        text=True,
        errors="replace",
    ) as child:
        try:
            log, _ = child.communicate(f"{link}\n{settings}", timeout=_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            child.kill()
            raise LinkError("The session there does not answer.") from None
    lines = log.splitlines()
    if _ADMITTED in lines:
        return
    raise LinkError(NOT_ADMITTED if _CONNECTED in lines else why_not_connected(log))


def main() -> None:
    """Run the child: reads the link's id and settings from standard input, prints Zenoh's log and
    the outcome.
    """
    import zenoh

    from sar_tui.link.zenoh_settings import LinkKeys, config

    link = sys.stdin.readline().strip()
    zenoh.init_log_from_env_or(GUEST_LOG)
    try:
        session = zenoh.open(config(sys.stdin.read()))
    except zenoh.ZError:
        return
    with session:
        print(_CONNECTED, flush=True)
        if any(
            reply.ok
            for reply in session.liveliness().get(
                LinkKeys(link).broadcast, timeout=_ANSWER_TIMEOUT_S
            )
        ):
            print(_ADMITTED, flush=True)


if __name__ == "__main__":
    main()
