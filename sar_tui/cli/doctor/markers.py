"""Checks of `sar-tui doctor` on markers for other recorders: LSL and serial lines."""

from sar_tui.cli.doctor.finding import Finding

_NOTE = "Only `--markers` needs it."


def lsl_markers() -> Finding:
    """Check that LSL is installed, and that its clock is the session's."""
    from importlib.util import find_spec

    from sar_tui.outputs.markers.lsl import SAME_CLOCK_NS, clock_offset_ns, library, no_package
    from sar_tui.outputs.markers.marker import MarkerError

    name = "Markers, LSL"
    if find_spec("pylsl") is None:
        return _not_installed(name, no_package())
    try:
        pylsl = library()
    except MarkerError as error:
        return Finding(name, "care", str(error), _NOTE)
    offset_ns = clock_offset_ns(pylsl)
    found = f"LSL {pylsl.library_version() / 100:.2f}"
    if abs(offset_ns) < SAME_CLOCK_NS:
        return Finding(
            name, "ok", f"{found}; its clock is the session's (differs by {offset_ns} ns)"
        )
    return Finding(
        name,
        "ok",
        f"{found}; its clock is another one, {offset_ns} ns ahead, which is added to stamps",
    )


def serial_markers() -> Finding:
    """Check that serial lines can be used, and name those that there are."""
    from importlib.util import find_spec

    from sar_tui.outputs.markers.serial_line import no_package

    name = "Markers, serial"
    if find_spec("serial") is None:
        return _not_installed(name, no_package())
    from serial.tools.list_ports import comports

    ports = sorted(port.device for port in comports())
    return Finding(
        name,
        "ok",
        f"ports: {', '.join(ports)}" if ports else "installed; there is no serial port now",
    )


def _not_installed(name: str, how: str) -> Finding:
    return Finding(
        name, "ok", f"not installed. {_NOTE}", f"To install it: {how.rpartition(': ')[2]}"
    )
