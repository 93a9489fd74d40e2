"""Schedules of augmented feedback: which attempts get feedback.

Each module of this package with a ``POLICY`` is a schedule (after Schmidt & Lee, Motor Control and
Learning, on augmented feedback). Its file name is the value of ``feedback_schedule``; its
parameters appear on the settings form of every task.
"""

from sar_tui.rules import registry
from sar_tui.rules.feedback.policy import FeedbackPolicy

POLICIES = registry.find(__name__, __path__, FeedbackPolicy)
