"""What `sar-tui doctor` looks at, one finding a function."""

import os
import platform
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from typing import Literal

import msgspec

from sar_tui.cli.common import Home
from sar_tui.cli.doctor.check import Finding, State
from sar_tui.cli.doctor.link import browser, invitations, operator_here
from sar_tui.cli.doctor.sensors import motion_sensor, sensor_driver
from sar_tui.cli.doctor.servo import servo_controller
from sar_tui.cli.doctor.speech import sound_card, speech_engine

SMALLEST = (80, 24)
"""Columns and lines that every screen fits in."""
_MEGABYTE = 1_000_000
_LITTLE, _TOO_LITTLE = 500 * _MEGABYTE, 20 * _MEGABYTE
_COARSE = 1e-3


def examine(home: Home) -> Iterator[Finding]:
    """Look at everything; a look that itself fails is a finding."""
    looks: tuple[tuple[str, Callable[[], Finding]], ...] = (
        ("Python", _python),
        ("Terminal", _terminal),
        ("Terminal size", _size),
        ("Colours", _colours),
        ("Connection", _connection),
        ("Clock", _clock),
        ("Onset stamps", _onset),
        ("Priority", _priority),
        ("Measured timing", lambda: _measured(home)),
        ("Sensor driver", sensor_driver),
        ("Motion sensor", motion_sensor),
        ("Servo controller", servo_controller),
        ("Speech", speech_engine),
        ("Sound card", sound_card),
        ("Operator here", operator_here),
        ("Invitations", lambda: invitations(home.folder)),
        ("Browser", browser),
        ("Data", lambda: _data(home)),
        ("Disk space", lambda: _space(home)),
        ("Tasks", lambda: _tasks(home)),
        ("Themes", lambda: _themes(home)),
        ("Outputs", _outputs),
    )
    for name, look in looks:
        try:
            yield look()
        except Exception as error:
            yield Finding(name, "bad", f"It cannot be told ({type(error).__name__}: {error}).")


def _python() -> Finding:
    import textual

    import sar_tui

    versions = f"sar-tui {sar_tui.__version__}, Textual {textual.__version__}, {platform.system()}"
    return Finding("Python", "ok", f"{platform.python_version()}, with {versions}")


# --- the terminal --------------------------------------------------------------------------------------------


def _terminal() -> Finding:
    term = os.environ.get("TERM", "")
    if term in ("dumb", "unknown"):
        return Finding("Terminal", "bad", f"TERM={term}: it cannot place text.", "Use another terminal program.")
    if not all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)):
        return Finding(
            "Terminal", "care", "Input or output is redirected here.", "The app needs a terminal; simulate does not."
        )
    return Finding("Terminal", "ok", os.environ.get("TERM_PROGRAM") or term or "console")


def _size() -> Finding:
    columns, lines = shutil.get_terminal_size(SMALLEST)
    if columns < SMALLEST[0] or lines < SMALLEST[1]:
        return Finding(
            "Terminal size", "care", f"{columns}×{lines}", f"Make the window {SMALLEST[0]}×{SMALLEST[1]} or larger."
        )
    return Finding("Terminal size", "ok", f"{columns}×{lines}")


def _colours() -> Finding:
    from rich.console import Console

    if "NO_COLOR" in os.environ:
        return Finding("Colours", "ok", "off, as NO_COLOR asks; nothing is told by colour alone")
    system = Console(force_terminal=True).color_system
    if system in (None, "standard"):
        return Finding(
            "Colours",
            "care",
            "16 or fewer; themes are shown as near as they can be",
            "Set TERM=xterm-256color or COLORTERM=truecolor if your terminal can do more.",
        )
    return Finding("Colours", "ok", {"truecolor": "16 million"}.get(str(system), str(system)))


def _connection() -> Finding:
    from sar_tui.store.provenance import machine

    facts = machine()
    if not facts["flags"]:
        return Finding("Connection", "ok", "directly at this machine")
    ways = " and ".join("SSH" if flag == "ssh" else flag for flag in facts["flags"])
    return Finding(
        "Connection",
        "care",
        f"through {ways}: it delays keys and frames, and each session is marked with it",
        "For timed sessions use a terminal on the machine itself, without a multiplexer.",
    )


# --- time ----------------------------------------------------------------------------------------------------


def _clock() -> Finding:
    name: Literal["perf_counter", "monotonic"] = "perf_counter" if sys.platform == "win32" else "monotonic"
    info = time.get_clock_info(name)
    found = f"{info.implementation}, resolution {info.resolution * 1e9:g} ns"
    if info.resolution > _COARSE:
        return Finding("Clock", "bad", found, "Reaction times need a clock finer than 1 ms: use another machine.")
    return Finding("Clock", "ok", found)


def _onset() -> Finding:
    """Whether Textual's driver has the file that the app watches; a private name, so it may go."""
    if sys.platform == "win32":
        has_file = False
    else:
        from textual.drivers.linux_driver import LinuxDriver

        has_file = "_file" in LinuxDriver.__init__.__code__.co_names
    if has_file:
        return Finding("Onset stamps", "ok", "taken as the prompt's frame is flushed to the terminal")
    return Finding(
        "Onset stamps",
        "care",
        "taken after Textual's refresh, which is less sure; each trial is marked with it",
        "Use Linux or macOS, and the version of Textual that sar-tui was released with, for timed sessions.",
    )


def _priority() -> Finding:
    if sys.platform == "win32":
        return Finding("Priority", "care", "not looked at on Windows", "Start it with: start /high sar-tui")
    if sys.platform == "linux" and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR):
        return Finding("Priority", "ok", "real-time scheduling")
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    if nice < 0:
        return Finding("Priority", "ok", f"raised (nice {nice})")
    how = "chrt --rr 10 sar-tui, or nice -n -10 sar-tui" if sys.platform == "linux" else "nice -n -10 sar-tui"
    return Finding(
        "Priority",
        "care",
        f"ordinary (nice {nice}): now and then another program may delay a key by tens of ms",
        f"Close other programs; or, where you may, start it with {how}.",
    )


def _measured(home: Home) -> Finding:
    from sar_tui.cli.timing import FILE, VERDICTS

    path = home.folder / FILE
    if not path.is_file():
        return Finding("Measured timing", "care", "not measured here yet", "Run `sar-tui timing`.")
    try:
        figures = msgspec.json.decode(path.read_bytes())
        found = (
            f"{figures['verdict']}: error {figures['median_ms']:.2f} ms, robust SD {figures['robust_sd_ms']:.2f} ms, "
            f"99th percentile {figures['p99_ms']:.2f} ms, on {figures['measured_at'][:10]}"
        )
    except (msgspec.DecodeError, KeyError, TypeError, ValueError):
        return Finding("Measured timing", "care", f"{path} cannot be read.", "Run `sar-tui timing` again.")
    if figures["verdict"] == VERDICTS[0]:
        return Finding("Measured timing", "ok", found)
    return Finding("Measured timing", "care", found, "`sar-tui timing` says why.")


# --- data and plug-ins ---------------------------------------------------------------------------------------


def _data(home: Home) -> Finding:
    from sar_tui.store.database import FILE, StoreError

    try:
        with home.database() as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            (state,) = database.execute("PRAGMA quick_check(1)").fetchone()
    except StoreError as error:
        return Finding("Data", "bad", str(error), "Choose another folder with --data or SAR_TUI_DATA.")
    path = home.folder / FILE
    if state != "ok":
        return Finding("Data", "bad", f"{path} is damaged: {state}.", "Restore a backup.")
    return Finding("Data", "ok", f"{path}, data version {version}, can be written to")


def _space(home: Home) -> Finding:
    place = next(folder for folder in (home.folder.resolve(), *home.folder.resolve().parents) if folder.exists())
    free = shutil.disk_usage(place).free
    found = f"{free / 1000 / _MEGABYTE:.1f} GB free" if free > 1000 * _MEGABYTE else f"{free / _MEGABYTE:.0f} MB free"
    state: State = "bad" if free < _TOO_LITTLE else "care" if free < _LITTLE else "ok"
    return Finding(
        "Disk space", state, found, "" if state == "ok" else "Free some space: a full disk pauses a session."
    )


def _tasks(home: Home) -> Finding:
    from sar_tui.plugins import PluginError

    try:
        catalogue = home.catalogue()
    except PluginError as error:
        return Finding("Tasks", "bad", str(error), "Name a folder that exists with --tasks.")
    return _plugins("Tasks", catalogue.task_names(), catalogue.task, "`sar-tui tasks check FOLDER` says more.")


def _themes(home: Home) -> Finding:
    catalogue = home._replace(tasks=()).catalogue()
    return _plugins("Themes", catalogue.theme_names(), catalogue.theme, "Mend its folder, or remove it.")


def _outputs() -> Finding:
    """Those that there are; a plug-in among them is loaded, but not made: with what, only a session knows."""
    from importlib.metadata import entry_points

    from sar_tui.outputs.outputs import GROUP, output_names

    problems = []
    for entry in entry_points(group=GROUP):
        try:
            entry.load()
        except Exception as error:
            problems.append(
                f"The output {entry.name} ({entry.value}) cannot be loaded: {type(error).__name__}: {error}."
            )
    if problems:
        return Finding("Outputs", "bad", " ".join(problems), "Install its package again, or remove it.")
    return Finding("Outputs", "ok", ", ".join(output_names()))


def _plugins(name: str, names: list[str], load: Callable[[str], object], mend: str) -> Finding:
    from sar_tui.plugins import PluginError

    problems = []
    for each in names:
        try:
            load(each)
        except PluginError as error:
            problems.append(str(error))
    if problems:
        return Finding(name, "bad", " ".join(problems), mend)
    if not names:
        return Finding(name, "bad", "There are none.", "Install sar-tui again.")
    return Finding(name, "ok", ", ".join(names))
