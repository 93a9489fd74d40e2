"""Every topic and service of the system, by name.

Databases and recordings hold these names, so a name never changes once it was released.
"""

from typing import Any

from sar_tui.loop.bus import FAULT, Service, Topic
from sar_tui.model import messages as m

SESSION = Topic("session/started", m.SessionStarted, origin="input", keep=True)
THEME = Topic("theme/applied", m.ThemeApplied, origin="input", keep=True)
KEY = Topic("input/key", m.KeyPressed, origin="input")
SWITCH = Topic("input/switch", m.SwitchPressed, origin="input")
PASTE = Topic("input/paste", m.Pasted, origin="input")
UNREADABLE = Topic("input/unreadable", m.InputDropped, origin="input")
FOCUS = Topic("input/focus", m.FocusChanged, origin="input")
SHOWN = Topic("screen/shown", m.Shown, origin="input")
TRIAL_FEEDBACK_SHOWN = Topic("screen/trial_feedback", m.TrialFeedbackShown, origin="input")
TONE_BEGAN = Topic("output/tone", m.ToneBegan, origin="input")
IMU = Topic("input/imu", m.ImuBlock, origin="input", stream=True)
SENSOR = Topic("input/sensor", m.SensorChanged, origin="input")
TRUNK_IMU = Topic("input/trunk_imu", m.ImuBlock, origin="input", stream=True)
TRUNK_SENSOR = Topic("input/trunk_sensor", m.SensorChanged, origin="input")
TIMER = Topic("timer/fired", m.TimerFired, origin="input")
COMMAND = Topic("operator/act", m.SessionCommand, origin="input")
SETTING = Topic("operator/setting", m.SettingChanged, origin="input")
DECISION = Topic("operator/decision", m.Decision, origin="input")
REMARK = Topic("operator/remark", m.Remark, origin="input")
MODE = Topic("operator/mode", m.ModeChanged, origin="input")
PROPOSAL_SEEN = Topic("operator/seen", m.ProposalSeen, origin="input")
NOTE_ADDED = Topic("operator/note", m.NoteAdded, origin="input")
PRESENCE = Topic("operator/presence", m.OperatorChanged, origin="input", keep=True)
REFUSED = Topic("operator/refused", m.PeerRequestRefused, origin="input")
REPORT = Topic("output/report", m.OutputReport, origin="input")
OUTPUT = Topic("output/opened", m.OutputOpened, origin="input")
STOPPED = Topic("output/stopped", m.OutputStopped, origin="input")
MARKERS = Topic("output/markers", m.MarkersChanged, origin="input")
SYNC = Topic("output/sync", m.SyncSignal, origin="input")
STORED = Topic("store/stored", m.Stored, origin="input")
STORAGE = Topic("store/changed", m.StorageChanged, origin="input")
RECORD_CHANGED = Topic("record/status", m.RecordChanged, origin="later")

PERCEIVED = Topic("perception/key", m.KeyPerceived)
REACH = Topic("perception/reach", m.ReachPerceived)
WAITING = Topic("event_handler/waiting", m.Waiting, keep=True)
ATTEMPT_STARTED = Topic("event_handler/attempt_started", m.AttemptStarted)
CUE = Topic("event_handler/cue", m.CueGiven)
PROMPT = Topic("event_handler/prompt", m.Prompt)
FRAME = Topic("event_handler/frame", m.FrameDue)
TONES_AHEAD = Topic("event_handler/tones_ahead", m.TonesAhead)
TONE_DUE = Topic("event_handler/tone", m.ToneDue)
TYPED = Topic("event_handler/typed", m.Typed)
VOIDED = Topic("event_handler/voided", m.PromptVoided)
TRIAL = Topic("event_handler/trial", m.TrialEnded)
TRIAL_FEEDBACK = Topic("event_handler/trial_feedback", m.TrialFeedback)
MARKED = Topic("event_handler/marked", m.TrialMarked)
ATTEMPT_ENDED = Topic("event_handler/attempt_ended", m.AttemptEnded)
LEVEL = Topic("event_handler/level", m.LevelChanged, keep=True)
GOAL = Topic("event_handler/goal", m.GoalChanged, keep=True)
STEP_ENDED = Topic("event_handler/step_ended", m.StepEnded)
FEEDBACK = Topic("event_handler/feedback", m.Feedback)
SESSION_ENDED = Topic("event_handler/session_ended", m.SessionEnded)
PROPOSED = Topic("action_center/proposed", m.Proposal)
PENDING_APPROVAL = Topic("arbiter/pending_approval", m.PendingApproval)
ARBITER_STATE = Topic("arbiter/state", m.ArbiterState, keep=True)
FILLER_DUE = Topic("arbiter/filler_due", m.FillerDue)
LEVEL_DECIDED = Topic("arbiter/level_decided", m.LevelDecided)
ANSWERED = Topic("operator/answered", m.ActAnswered)
LATE_DECISION = Topic("arbiter/late_decision", m.LateDecision)
DECIDED = Topic("arbiter/decided", m.Action)
ACTION = Topic("arbiter/action", m.Action)
DROPPED = Topic("arbiter/dropped", m.Dropped)
HALT = Topic("arbiter/halt", m.Halt)
ACTING = Topic("arbiter/acting", m.AgentActing, keep=True)

RECALL = Service("memory/recall", m.Recall, m.RecalledAttempts)
LEVEL_REQUEST = Service("arbiter/level", m.LevelRequest, m.LevelReply)
UNSAID_FEEDBACK = Service("arbiter/unsaid", m.UnsaidFeedbackRequest, m.UnsaidFeedback)

ALL: dict[str, Topic[Any]] = {
    topic.name: topic for topic in (*vars().values(), FAULT) if isinstance(topic, Topic)
}
"""Topics by name, to read recorded messages."""
