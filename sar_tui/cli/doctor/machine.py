"""Checks of the installation, the terminal, the timing of this machine, and the stored data."""

import os
import platform
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import closing
from typing import Literal

import msgspec

from sar_tui.cli.common import CANNOT_PLACE_TEXT, terminal_kind
from sar_tui.cli.doctor.finding import Finding, Machine, bad, care, not_installed, ok
from sar_tui.cli.scaffold import replaced_lines

SMALLEST = (80, 24)
"""Columns and lines that every screen fits in."""
_COARSE_S = 1e-3
_MEGABYTE = 1_000_000
_LITTLE, _TOO_LITTLE = 500 * _MEGABYTE, 20 * _MEGABYTE


def python(_: Machine) -> Finding:
    """Report the versions."""
    import textual

    import sar_tui

    versions = f"sar-tui {sar_tui.__version__}, Textual {textual.__version__}, {platform.system()}"
    return ok(f"{platform.python_version()}, with {versions}")


def terminal(_: Machine) -> Finding:
    """Check that the program runs in a terminal that can place text."""
    term = terminal_kind()
    if term in CANNOT_PLACE_TEXT:
        return bad(f"TERM={term}: it cannot place text.", "Use another terminal program.")
    if not all(
        stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)
    ):
        return care(
            "Input or output is redirected here.", "The app needs a terminal; simulate does not."
        )
    if not term:
        return bad("TERM is empty.", "Set it to your terminal's kind, such as xterm-256color.")
    return ok(os.environ.get("TERM_PROGRAM") or term)


def size(_: Machine) -> Finding:
    """Check that the terminal is large enough."""
    columns, lines = shutil.get_terminal_size(SMALLEST)
    if columns < SMALLEST[0] or lines < SMALLEST[1]:
        return care(f"{columns}×{lines}", f"Make the window {SMALLEST[0]}×{SMALLEST[1]} or larger.")
    return ok(f"{columns}×{lines}")


def colours(_: Machine) -> Finding:
    """Check how many colours the terminal can show."""
    from rich.console import Console

    if "NO_COLOR" in os.environ:
        return ok(
            "off, as NO_COLOR asks; only tasks whose prompts have colours cannot be done here"
        )
    system = Console(force_terminal=True).color_system
    if system in (None, "standard"):
        return care(
            "16 or fewer; the colours of themes are approximated",
            "Set TERM=xterm-256color or COLORTERM=truecolor if your terminal can do more.",
        )
    return ok({"truecolor": "16 million"}.get(str(system), str(system)))


def pictures(_: Machine) -> Finding:
    """Find out how the terminal shows the pictures of prompts. Asks it."""
    from sar_tui.widgets.prompt_pictures import find_way, no_package

    way = find_way()
    if way is None:
        return not_installed(no_package(), "Only tasks whose prompts have pictures need it.")
    as_they_are = {"kitty": "by kitty's graphics", "sixel": "by sixel graphics"}
    return ok(as_they_are.get(way) or f"in {way}, as this terminal has no graphics")


def connection(_: Machine) -> Finding:
    """Check that there is neither SSH nor a multiplexer between the person and the program."""
    from sar_tui.store.provenance import machine

    facts = machine()
    if not facts["flags"]:
        return ok("directly at this machine")
    ways = " and ".join("SSH" if flag == "ssh" else flag for flag in facts["flags"])
    return care(
        f"through {ways}: it delays keys and frames, and each session is marked with it",
        "For timed sessions use a terminal on the machine itself, without a multiplexer.",
    )


def clock(_: Machine) -> Finding:
    """Check the resolution of the clock."""
    name: Literal["perf_counter", "monotonic"] = (
        "perf_counter" if sys.platform == "win32" else "monotonic"
    )
    info = time.get_clock_info(name)
    found = f"{info.implementation}, resolution {info.resolution * 1e9:g} ns"
    if info.resolution > _COARSE_S:
        return bad(found, "Reaction times need a clock finer than 1 ms: use another machine.")
    return ok(found)


def onset_stamps(_: Machine) -> Finding:
    """Check that Textual's driver has the file that the app watches; its name is private, so it may
    change.
    """
    if sys.platform == "win32":
        has_file = False
    else:
        from textual.drivers.linux_driver import LinuxDriver

        has_file = "_file" in LinuxDriver.__init__.__code__.co_names
    if has_file:
        return ok("taken as the prompt's frame is flushed to the terminal")
    return care(
        "taken after Textual's refresh, which is less accurate; each trial is marked with it",
        "Use Linux or macOS, and the version of Textual that sar-tui was released with, for timed "
        "sessions.",
    )


def priority(_: Machine) -> Finding:
    """Check the scheduling priority of the process."""
    if sys.platform == "win32":
        return care("not checked on Windows", "Start it with: start /high sar-tui")
    if sys.platform == "linux" and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR):
        return ok("real-time scheduling")
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    if nice < 0:
        return ok(f"raised (nice {nice})")
    how = (
        "chrt --rr 10 sar-tui, or nice -n -10 sar-tui"
        if sys.platform == "linux"
        else "nice -n -10 sar-tui"
    )
    return care(
        f"ordinary (nice {nice}): now and then another program may delay a key by tens of ms",
        f"Close other programs; or, if you are allowed to, start it with {how}.",
    )


def measured_timing(here: Machine) -> Finding:
    """Report the figures that ``sar-tui timing`` stored in a data folder."""
    from sar_tui.timing.verdict import FILE, VERDICTS

    path = here.home.folder / FILE
    if not path.is_file():
        return care("not measured here yet", "Run `sar-tui timing`.")
    try:
        figures = msgspec.json.decode(path.read_bytes())
        found = (
            f"{figures['verdict']}: error {figures['median_ms']:.2f} ms, robust SD "
            f"{figures['robust_sd_ms']:.2f} ms, "
            f"99th percentile {figures['p99_ms']:.2f} ms, on {figures['measured_at'][:10]}"
        )
    except (msgspec.DecodeError, KeyError, TypeError, ValueError):
        return care(f"{path} cannot be read.", "Run `sar-tui timing` again.")
    if figures["verdict"] == VERDICTS[0]:
        return ok(found)
    return care(found, "`sar-tui timing` says why.")


def database(here: Machine) -> Finding:
    """Check that the database can be opened and is not damaged."""
    from sar_tui.store.database import FILE, StoreError, connect

    try:
        with closing(connect(here.home.folder)) as opened:
            (version,) = opened.execute("PRAGMA user_version").fetchone()
            (state,) = opened.execute("PRAGMA quick_check(1)").fetchone()
    except StoreError as error:
        return bad(str(error), "Choose another folder with --data or SAR_TUI_DATA.")
    path = here.home.folder / FILE
    if state != "ok":
        return bad(
            f"{path} is damaged: {state}.",
            "Restore a backup, or save what can be read: `sar-tui check --repair`.",
        )
    return ok(f"{path}, data version {version}, can be written to")


def saved_data(here: Machine) -> Finding:
    """Check that the database has all that was saved."""
    from sar_tui.store.database import FILE, SAVED, StoreError, connect_to_read
    from sar_tui.store.rescue import rescue_files
    from sar_tui.store.safeguard import losses

    folder = here.home.folder
    if files := rescue_files(folder):
        found = f"{', '.join(map(str, files))}: holds data that is not in the database."
        return bad(found, "Run `sar-tui rescue`, which brings it back.")
    if not any(os.path.exists(folder / name) for name in (FILE, SAVED)):
        return ok("nothing was saved yet")
    try:
        with closing(connect_to_read(folder)) as opened:
            lost = losses(opened, folder)
    except StoreError as error:
        return bad(str(error))
    if not lost:
        return ok("all that was saved is in the database")
    notes = " and ".join(str(loss.note) for loss in lost)
    advice = (
        "The log of the database was damaged or deleted. Restore a backup, or delete "
        f"{notes} to accept it."
    )
    return bad(" ".join(map(str, lost)), advice)


def disk_space(here: Machine) -> Finding:
    """Check that the disk of the data folder has room."""
    folder = here.home.folder.resolve()
    place = next(existing for existing in (folder, *folder.parents) if existing.exists())
    free = shutil.disk_usage(place).free
    gigabytes, megabytes = free / 1000 / _MEGABYTE, free / _MEGABYTE
    found = f"{gigabytes:.1f} GB free" if gigabytes > 1 else f"{megabytes:.0f} MB free"
    if free >= _LITTLE:
        return ok(found)
    advice = "Free some space: a full disk pauses a session."
    return bad(found, advice) if free < _TOO_LITTLE else care(found, advice)


def tasks(here: Machine) -> Finding:
    """Load every task."""
    from sar_tui.plugins import PluginError

    try:
        catalogue = here.home.catalogue()
    except PluginError as error:
        return bad(str(error), "Name a folder that exists with --tasks.")
    found = _loaded(
        catalogue.task_names(), catalogue.task, "`sar-tui tasks check FOLDER` says more."
    )
    if found.state == "ok" and (lines := replaced_lines(catalogue.replaced_tasks())):
        return care(" ".join(lines), "Give it a name of its own if this is not meant.")
    return found


def themes(here: Machine) -> Finding:
    """Load every theme."""
    catalogue = here.home._replace(tasks=()).catalogue()
    return _loaded(catalogue.theme_names(), catalogue.theme, "Fix its folder, or remove it.")


def outputs(_: Machine) -> Finding:
    """Load the plug-ins among the outputs. None is opened, because only a session knows its
    address.
    """
    from sar_tui.outputs.output import OutputError
    from sar_tui.outputs.outputs import INSTALLED, output_names

    problems = []
    for name in sorted(INSTALLED.names()):
        try:
            INSTALLED.load(name)
        except OutputError as error:
            problems.append(str(error))
    if problems:
        return bad(" ".join(problems), "Install its package again, or remove it.")
    return ok(", ".join(output_names()))


def policies(_: Machine) -> Finding:
    """Name the policies of difficulty and feedback, and those that cannot be used."""
    from sar_tui.rules.parameters import TaskParameters, fields
    from sar_tui.rules.policies import BY_CHOICE, FAILED

    choices = [field.choices for field in fields(TaskParameters) if field.name in BY_CHOICE]
    if FAILED:
        return bad(" ".join(FAILED.values()), "Fix its file or its package, or remove it.")
    return ok(", ".join(name for names in choices for name in names))


def _loaded(names: list[str], load: Callable[[str], object], advice: str) -> Finding:
    from sar_tui.plugins import PluginError

    problems = []
    for each in names:
        try:
            load(each)
        except PluginError as error:
            problems.append(str(error))
    if problems:
        return bad(" ".join(problems), advice)
    if not names:
        return bad("There are none.", "Install sar-tui again.")
    return ok(", ".join(names))
