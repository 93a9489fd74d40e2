"""Messages of the loop. Frozen; times are ns of the session's clock unless the name says otherwise.

Messages hold no session id and no participant code: two sessions with the same seed and the same
presses hold the same messages.
"""

# ruff: noqa: F403 - each module lists its names in __all__

from sar_tui.model.messages.agent import *
from sar_tui.model.messages.base import *
from sar_tui.model.messages.inputs import *
from sar_tui.model.messages.loop import *
from sar_tui.model.messages.operator import *
