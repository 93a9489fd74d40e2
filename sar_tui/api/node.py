"""For a node: the loop's building blocks, all topics with their messages, and movement analysis.

The analysis needs numpy, and is loaded when it is first used.
"""

# ruff: noqa: F403, F405 - the messages and the topics are those of their modules

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.loop.bus import FAULT, Bus, Record, Service, Topic
from sar_tui.loop.clock import Clock, VirtualClock, host_now
from sar_tui.loop.node import Node, TimedNode, on, serves
from sar_tui.loop.topics import *
from sar_tui.model.messages import *
from sar_tui.model.units import MS, SECOND

if TYPE_CHECKING:
    from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
    from sar_tui.motion.arrays import turning_points
    from sar_tui.motion.filters import lowpass, smooth
    from sar_tui.motion.repetitions import Repetitions, count_repetitions
    from sar_tui.motion.samples import (
        SAMPLE,
        Floats,
        Recording,
        Samples,
        join,
        pack,
        recording,
        unpack,
    )
    from sar_tui.motion.smoothness import ldlj, sparc
    from sar_tui.perception.kept_samples import KeptSamples

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # nodes, and how they are joined
    "Node", "TimedNode", "on", "serves", "Topic", "Service", "Bus", "Record",
    # time
    "Clock", "VirtualClock", "host_now", "MS", "SECOND",
    # topics of inputs
    "SESSION", "THEME", "KEY", "SWITCH", "PASTE", "UNREADABLE", "FOCUS", "SHOWN",
    "TRIAL_FEEDBACK_SHOWN", "TONE_BEGAN", "IMU", "SENSOR", "TRUNK_IMU", "TRUNK_SENSOR",
    "TIMER", "COMMAND", "SETTING", "DECISION", "REMARK", "MODE", "PROPOSAL_SEEN",
    "NOTE_ADDED", "PROTOCOL", "PROTOCOL_TICKED", "REASON", "PRESENCE", "VISIT", "REFUSED",
    "REPORT",
    "OUTPUT", "STOPPED", "MARKERS", "SYNC", "STORED", "STORAGE", "RECORD_CHANGED", "ERASED",
    # topics of what follows from them
    "FAULT", "PERCEIVED", "REACH", "WAITING", "ATTEMPT_STARTED", "CUE", "PROMPT", "FRAME",
    "TONES_AHEAD", "TONE_DUE", "TYPED", "VOIDED", "TRIAL", "TRIAL_FEEDBACK", "MARKED",
    "ATTEMPT_ENDED", "LEVEL", "GOAL", "STEP_ENDED", "FEEDBACK", "TAKEN_BACK", "SESSION_ENDED",
    "PROPOSED",
    "PENDING_APPROVAL", "ARBITER_STATE", "FILLER_DUE", "LEVEL_DECIDED", "LATE_DECISION",
    "DECIDED", "ACTION", "DROPPED", "HALT", "ACTING", "PROTOCOL_DUE", "ANSWERED",
    "VISIT_DECIDED",
    # services
    "RECALL", "LEVEL_REQUEST", "UNSAID_FEEDBACK",
    # messages
    "ActAnswered", "Action", "AgentActing", "ArbiterState", "AskedStep", "AttemptEnded",
    "AttemptStarted", "BodyPart", "CueGiven", "Decision", "Dropped", "EndStatus", "Fault",
    "Erased",
    "Feedback", "FeedbackChoice", "FillerDue", "FocusChanged", "FrameDue", "GoalChanged", "Halt",
    "ImuBlock", "InputDropped", "KeyPerceived", "KeyPressed", "LateDecision", "LevelChanged",
    "LevelDecided", "LevelReply", "LevelRequest", "MarkersChanged", "Message", "ModeChanged",
    "NoteAdded", "OperatorAct", "OperatorChanged", "OutputOpened", "OutputReport", "OutputStopped",
    "Pasted", "PeerRequestRefused", "PendingApproval", "Percept", "Prompt", "PromptVoided",
    "Proposal", "ProposalSeen", "ProtocolChosen", "ProtocolDue", "ProtocolTicked", "ReachPerceived",
    "ReasonGiven", "Recall", "RecalledAttempts", "RecordChange",
    "RecordChanged", "Remark", "SensorChanged", "SessionCommand", "SessionEnded", "SessionStarted",
    "SettingChanged", "Shown", "Spread", "StepEnded", "StepStatus", "StorageChanged", "Stored",
    "SwitchPressed", "SyncSignal", "TakenBack", "TakenBackKind", "TextPerceived", "ThemeApplied",
    "TimerFired", "Timing", "ToneBegan", "ToneDue",
    "TonesAhead", "TrialEnded", "TrialFeedback", "TrialFeedbackShown", "TrialMarked", "Typed",
    "UnsaidFeedback", "UnsaidFeedbackRequest", "Utterance", "VisitDecided", "VisitRequested",
    "Waiting",
    # values of their fields
    "ActOutcome", "ActionPart", "ControlledKind", "Degree", "Form", "Ground", "Json", "Kind",
    "Mode", "Outcome", "PartState", "Policy", "Reference", "Role", "SensorState", "Valence",
    # a sensor's samples
    "SAMPLE", "Samples", "Floats", "Recording", "KeptSamples", "pack", "unpack", "join",
    "recording",
    # movement analysis
    "analyse", "AnalysisParameters", "Window", "Finding", "lowpass", "smooth", "turning_points",
    "sparc", "ldlj", "count_repetitions", "Repetitions",
]
# fmt: on

_LOADED_LATER = {
    "sar_tui.motion.analysis": "AnalysisParameters Finding Window analyse",
    "sar_tui.motion.filters": "lowpass smooth",
    "sar_tui.motion.repetitions": "Repetitions count_repetitions",
    "sar_tui.motion.samples": "SAMPLE Floats Recording Samples join pack recording unpack",
    "sar_tui.motion.smoothness": "ldlj sparc",
    "sar_tui.motion.arrays": "turning_points",
    "sar_tui.perception.kept_samples": "KeptSamples",
}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)
