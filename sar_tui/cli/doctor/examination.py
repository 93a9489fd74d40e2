"""All checks of ``sar-tui doctor``, in the order in which they are printed."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor

from sar_tui.cli.common import Home
from sar_tui.cli.doctor.data_in_git import examine_data_in_git
from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.installation import outputs, policies, python, tasks, themes
from sar_tui.cli.doctor.link import browser, invitations, operator_here
from sar_tui.cli.doctor.markers import lsl_markers, serial_markers
from sar_tui.cli.doctor.sensors import motion_sensor, sensor_driver
from sar_tui.cli.doctor.servo import servo_controller
from sar_tui.cli.doctor.speech import examine_voice, sound_card, speech_engine
from sar_tui.cli.doctor.storage import database, disk_space, saved_data
from sar_tui.cli.doctor.terminal import colours, connection, pictures, size, terminal
from sar_tui.cli.doctor.timing import clock, measured_timing, onset_stamps, priority

Check = Callable[[], Finding]


def examine(home: Home) -> Iterator[Finding]:
    """Run every check. A check that raises is itself a finding.

    Those that wait for a device or a child process wait side by side, while the others are run.
    """
    with ThreadPoolExecutor() as pool:
        for name, check in _checks(home, pool):
            try:
                yield check()
            except Exception as error:
                yield Finding(name, "bad", f"This check failed ({type(error).__name__}: {error}).")


def _checks(home: Home, pool: Executor) -> Sequence[tuple[str, Check]]:
    """Return the checks by name, in the order of their findings. Those that wait are started in the
    pool.
    """
    voice = pool.submit(examine_voice).result
    return (
        ("Python", python),
        ("Terminal", terminal),
        ("Terminal size", size),
        ("Colours", colours),
        ("Pictures", pictures),
        ("Connection", connection),
        ("Clock", clock),
        ("Onset stamps", onset_stamps),
        ("Priority", priority),
        ("Measured timing", lambda: measured_timing(home.folder)),
        ("Sensor driver", pool.submit(sensor_driver).result),
        ("Motion sensor", pool.submit(motion_sensor).result),
        ("Servo controller", pool.submit(servo_controller).result),
        ("Speech", lambda: speech_engine(voice)),
        ("Sound card", lambda: sound_card(voice)),
        ("Markers, LSL", pool.submit(lsl_markers).result),
        ("Markers, serial", serial_markers),
        ("Operator here", operator_here),
        ("Invitations", lambda: invitations(home.folder)),
        ("Browser", browser),
        ("Data", lambda: database(home)),
        ("Saved data", lambda: saved_data(home.folder)),
        ("Data and git", pool.submit(examine_data_in_git, home.folder).result),
        ("Disk space", lambda: disk_space(home.folder)),
        ("Tasks", lambda: tasks(home)),
        ("Themes", lambda: themes(home)),
        ("Outputs", outputs),
        ("Policies", policies),
    )
