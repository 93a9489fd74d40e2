"""Tries once to reach a session, in a process of its own: only there can be read what zenoh says of a refusal."""

import os
import subprocess
import sys

from sar_tui.drivers import child_process
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.refusals import GUEST_LOG, log_environment, why_not_connected

_PATIENCE_SECONDS = 10.0
_ANSWER_SECONDS = 2.0
_CAME_IN, _LET_IN = "came in", "was let in"
NOT_LET_IN = (
    "The session there does not let this invitation in: it was revoked, or made after that session began. Ask for a "
    "new one, or have the session begun anew."
)


def probe(settings: str, link: str) -> None:
    """See whether a session lets a guest in, who connects with these settings to that link. Takes up to ten seconds.

    Raises:
        LinkError: it does not; why, as far as it can be known.
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
            log, _ = child.communicate(f"{link}\n{settings}", timeout=_PATIENCE_SECONDS)
        except subprocess.TimeoutExpired:
            child.kill()
            raise LinkError("The session there does not answer.") from None
    said = log.splitlines()
    if _LET_IN in said:
        return
    raise LinkError(NOT_LET_IN if _CAME_IN in said else why_not_connected(log))


def main() -> None:
    """The child: the link's id and settings on standard input, the log and the outcome on standard output."""
    import zenoh

    from sar_tui.link.settings import LinkKeys, config

    link = sys.stdin.readline().strip()
    zenoh.init_log_from_env_or(GUEST_LOG)
    try:
        session = zenoh.open(config(sys.stdin.read()))
    except zenoh.ZError:
        return
    with session:
        print(_CAME_IN, flush=True)
        if any(reply.ok for reply in session.liveliness().get(LinkKeys(link).out, timeout=_ANSWER_SECONDS)):
            print(_LET_IN, flush=True)


if __name__ == "__main__":
    main()
