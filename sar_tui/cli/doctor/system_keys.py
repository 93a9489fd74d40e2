"""Check of the system's accessibility settings of the keyboard: slow, sticky and bounce keys."""

import platform
import subprocess
from typing import NamedTuple

from sar_tui.cli.doctor.finding import Finding, Machine, care, ok

_ASK_S = 3.0
"""Longest time to wait for the program that tells a setting."""


class SystemKeys(NamedTuple):
    """Settings of a system. Times are in ms.

    Attributes:
        where: they are set.
        slow: time for which a key must be held before it counts; None if slow keys are off, 0 if
            they are on and the time is not told.
        bounce: time in which the same key again does not count; None if bounce keys are off.
        has_sticky: True if a modifier key stays down until the next key.
    """

    where: str
    slow: int | None
    bounce: int | None
    has_sticky: bool


class Untold(Exception):
    """The system does not tell a setting."""


def system_keys(_: Machine) -> Finding:
    """Find out what the system does to the keys of people who need help with typing."""
    ask = {"Linux": _gnome, "Darwin": _macos, "Windows": _windows}.get(platform.system())
    try:
        if ask is None:
            raise Untold
        told = ask()
    except (Untold, ValueError, IndexError):
        return ok(
            "slow, sticky and bounce keys are not known here",
            "Look at the system's accessibility settings of the keyboard.",
        )
    slow, sticky = told.slow is not None, told.has_sticky
    used = [
        *([f"slow keys{_ms(told.slow)}"] if slow else []),
        *(["sticky keys"] if sticky else []),
        *([f"bounce keys{_ms(told.bounce)}"] if told.bounce is not None else []),
    ]
    if not used:
        return ok(f"no slow, sticky or bounce keys in {told.where}")
    found = f"{', '.join(used)} in {told.where}"
    record = "Who needs them keeps them. Record it with the person's sessions: --set system_keys="
    if slow:
        kinds = "both" if sticky else "slow"
        return care(
            f"{found}: slow keys are part of each reaction time",
            f"{record}{kinds} --set added_delay_ms={told.slow or 'MS'}",
        )
    return ok(found, f"{record}sticky" if sticky else "")


def _ms(time: int | None) -> str:
    return f" ({time} ms)" if time else ""


# --- the systems


def _gnome() -> SystemKeys:
    def ask(name: str) -> str:
        return _output("gsettings", "get", "org.gnome.desktop.a11y.keyboard", name).split()[-1]

    def delay(kind: str) -> int | None:
        return int(ask(f"{kind}keys-delay")) if ask(f"{kind}keys-enable") == "true" else None

    return SystemKeys("GNOME", delay("slow"), delay("bounce"), ask("stickykeys-enable") == "true")


def _macos() -> SystemKeys:
    """Ask for the keys of Apple's payload ``com.apple.universalaccess``. One that was never set is
    not stored.
    """

    def ask(name: str) -> int:
        try:
            return int(float(_output("defaults", "read", "com.apple.universalaccess", name)))
        except Untold as error:
            if "does not exist" in str(error):
                return 0
            raise

    slow = ask("slowKeyDelay") if ask("slowKey") else None
    return SystemKeys("macOS", slow, None, bool(ask("stickyKey")))


def _windows() -> SystemKeys:
    """Ask for what ``FILTERKEYS`` and ``STICKYKEYS`` are stored as. Their lowest flag means "on";
    with a bounce time there are no slow keys.
    """

    def ask(key: str, name: str) -> int:
        path = rf"HKCU\Control Panel\Accessibility\{key}"
        return int(_output("reg", "query", path, "/v", name).split()[-1])

    slow = bounce = None
    if ask("Keyboard Response", "Flags") & 1:
        bounce = ask("Keyboard Response", "BounceTime") or None
        if not bounce:
            slow = ask("Keyboard Response", "DelayBeforeAcceptance") or None
    return SystemKeys("Windows", slow, bounce, bool(ask("StickyKeys", "Flags") & 1))


def _output(*command: str) -> str:
    """Return what a program prints.

    Raises:
        Untold: it is not there, or fails; with what it says.
    """
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=_ASK_S, check=True)
    except subprocess.CalledProcessError as error:
        raise Untold(error.stderr) from error
    except (OSError, subprocess.SubprocessError) as error:
        raise Untold(str(error)) from error
    return ran.stdout
