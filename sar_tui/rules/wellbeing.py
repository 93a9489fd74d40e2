"""Rules on pain and tiredness: when to stop at once, and when to tell the therapist. Pure.

They advise people, and decide nothing: no session is refused or ended by them.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec

Moment = Literal["before", "pause", "after"]
HIGHEST = 10
"""The worst pain, and the greatest tiredness: both are rated from 0, as on a numeric rating scale
(NRS).
"""
SEVERE = 7
"""Ratings from here on are severe: on the NRS for pain, 1-3 is mild, 4-6 moderate, 7-10 severe."""
PAIN_ENDS = ("no pain", "worst pain imaginable")
"""The words at both ends of each scale of pain: 0 and 10. Kept as they are, so that ratings can be
compared.
"""
PAIN_SESSIONS = 4
"""Pain is an adverse reaction if it is new or worse over this number of sessions (FAST-INdiCATE
trial).
"""
TIRED_SESSIONS = 2
"""The same for tiredness. That trial confirms it by a clinical test; this rule asks for severe
ratings instead.
"""

StopReason = Literal["too much pain", "rising pain"]
Advice = Literal["shown", "stopped", "went on"]
"""Result of the advice not to train: it was shown, and then followed, or not."""
TellReason = Literal["stop", "stopped", "went on", "new pain", "worse pain", "tired"]


class PainLimits(msgspec.Struct, frozen=True):
    """Limits of pain, set by the therapist. No numeric rule to stop was found for stroke.

    ``highest``: more is a reason to stop; above 5 is the red zone of a pain-monitoring model for
    tendons (Silbernagel et al. 2007). ``rise``: so much more than before the session, too; a change
    of 2 is clinically important (Farrar et al. 2001).
    """

    highest: int = 5
    rise: int = 2


class SessionRatings(msgspec.Struct, frozen=True):
    """Ratings of one session; None if not asked, or not answered.

    ``pain_pause``: the worst in a pause. ``told_pain``: pain was said in a pause, with a number or
    without. ``limits``: those of the session. ``advice``: what came of the advice not to train;
    empty if it was not shown. ``began``: False for answers before a session that never began.
    """

    pain_before: int | None = None
    pain_pause: int | None = None
    pain_after: int | None = None
    fatigue_before: int | None = None
    fatigue_after: int | None = None
    told_pain: bool = False
    limits: PainLimits = PainLimits()
    advice: Advice | Literal[""] = ""
    began: bool = True

    @property
    def pain(self) -> int | None:
        """The worst pain of the session: at least 1 if it was told in a pause; None if nothing is
        known.
        """
        known = [
            rating
            for rating in (self.pain_before, self.pain_pause, self.pain_after)
            if rating is not None
        ]
        return max([*known, *([1] if self.told_pain else [])], default=None)

    @property
    def fatigue(self) -> int | None:
        """The greatest tiredness of the session; None if nothing is known."""
        known = [
            rating for rating in (self.fatigue_before, self.fatigue_after) if rating is not None
        ]
        return max(known, default=None)

    @property
    def is_reason_to_stop(self) -> bool:
        """True if pain at any moment was a reason to stop: see `stop_now`."""
        pains = (self.pain_before, self.pain_pause, self.pain_after)
        return any(stop_now(self.pain_before, pain, self.limits) is not None for pain in pains)


def stop_now(before: int | None, now: int | None, limits: PainLimits) -> StopReason | None:
    """Return why a person should stop and tell the therapist now; None if there is no reason.

    Args:
        before: pain before the session; None if it is not known, or ``now`` is that rating.
        now: pain now.
        limits: those that the therapist set.
    """
    if now is None:
        return None
    if now > limits.highest:
        return "too much pain"
    return "rising pain" if before is not None and now - before >= limits.rise else None


def tell_therapist(sessions: Sequence[SessionRatings]) -> tuple[TellReason, ...]:
    """Return what the therapist should be told after some sessions of a participant, oldest first.

    Sessions in which nothing is known of a symptom are left out for that symptom. Answers before a
    session that never began count only for the first two.

    - Stop: pain was a reason to stop when it was last told.
    - Stopped, went on: then the participant was advised not to train, and did as advised, or not.
    - New pain: none before the last four sessions, and some in each of them.
    - Worse pain: more in each of the last four than before them.
    - Tired: severe tiredness after each of the last two.

    The pain before is that of the session before those four; without one, the first rating of the
    four.
    """
    found: list[TellReason] = []
    known = [session for session in sessions if session.pain is not None]
    if known and known[-1].is_reason_to_stop:
        found.append("stop")
        if known[-1].advice in ("stopped", "went on"):
            found.append(known[-1].advice)
    known = [session for session in known if session.began]
    if len(known) >= PAIN_SESSIONS:
        recent = [session.pain or 0 for session in known[-PAIN_SESSIONS:]]
        earlier = (
            known[-PAIN_SESSIONS - 1].pain if len(known) > PAIN_SESSIONS else known[0].pain_before
        )
        if earlier is not None and min(recent) > earlier:
            found.append("worse pain" if earlier else "new pain")
    tired = [session.fatigue_after for session in sessions if session.fatigue_after is not None]
    if len(tired) >= TIRED_SESSIONS and min(tired[-TIRED_SESSIONS:]) >= SEVERE:
        found.append("tired")
    return tuple(found)
