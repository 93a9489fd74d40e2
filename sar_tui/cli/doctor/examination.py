"""All checks of ``sar-tui doctor``, in the order in which they are printed."""

from collections.abc import Callable, Iterator

from sar_tui.cli.common import Home
from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.installation import outputs, python, tasks, themes
from sar_tui.cli.doctor.link import browser, invitations, operator_here
from sar_tui.cli.doctor.sensors import motion_sensor, sensor_driver
from sar_tui.cli.doctor.servo import servo_controller
from sar_tui.cli.doctor.speech import sound_card, speech_engine
from sar_tui.cli.doctor.storage import database, disk_space
from sar_tui.cli.doctor.terminal import colours, connection, size, terminal
from sar_tui.cli.doctor.timing import clock, measured_timing, onset_stamps, priority


def examine(home: Home) -> Iterator[Finding]:
    """Run every check. A check that raises is itself a finding."""
    checks: tuple[tuple[str, Callable[[], Finding]], ...] = (
        ("Python", python),
        ("Terminal", terminal),
        ("Terminal size", size),
        ("Colours", colours),
        ("Connection", connection),
        ("Clock", clock),
        ("Onset stamps", onset_stamps),
        ("Priority", priority),
        ("Measured timing", lambda: measured_timing(home.folder)),
        ("Sensor driver", sensor_driver),
        ("Motion sensor", motion_sensor),
        ("Servo controller", servo_controller),
        ("Speech", speech_engine),
        ("Sound card", sound_card),
        ("Operator here", operator_here),
        ("Invitations", lambda: invitations(home.folder)),
        ("Browser", browser),
        ("Data", lambda: database(home)),
        ("Disk space", lambda: disk_space(home.folder)),
        ("Tasks", lambda: tasks(home)),
        ("Themes", lambda: themes(home)),
        ("Outputs", outputs),
    )
    for name, check in checks:
        try:
            yield check()
        except Exception as error:
            yield Finding(name, "bad", f"This check failed ({type(error).__name__}: {error}).")
