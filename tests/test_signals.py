"""Programs that tests start can be ended by signals, however the tests themselves were started."""

import os
import signal
import subprocess
import sys

import pytest

from tests.signals import let_programs_heed_signals

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX systems")


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT, signal.SIGTERM])
def test_a_program_heeds_a_signal_that_the_tests_ignore(number: int) -> None:
    before = signal.signal(number, signal.SIG_IGN)
    try:
        let_programs_heed_signals()
        waits = "import signal; print(flush=True); signal.pause()"
        with subprocess.Popen(
            [sys.executable, "-c", waits], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        ) as program:
            assert program.stdout
            program.stdout.readline()
            os.kill(os.getpid(), number)
            program.send_signal(number)
            assert program.wait(60) == -number
    finally:
        signal.signal(number, before)
