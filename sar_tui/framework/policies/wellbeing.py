"""Rules on pain and tiredness: when to stop at once, and when to tell the therapist. Pure.

They advise people, and decide nothing: no session is refused or ended by them.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec

Moment = Literal["before", "pause", "after"]
HIGHEST = 10
"""The worst pain, and the greatest tiredness: both are rated from 0, as on a numeric rating scale (NRS)."""
SEVERE = 7
"""Ratings from here on are severe: on the NRS for pain, 1-3 is mild, 4-6 moderate, 7-10 severe."""
RISE = 3
"""A rise of pain within a session that is large. A change of 2 is clinically important (Farrar et al. 2001)."""
PAIN_SESSIONS = 4
"""Pain is an adverse reaction if it is new or worse over this number of sessions (FAST-INdiCATE trial)."""
TIRED_SESSIONS = 2
"""The same for tiredness. That trial confirms it by a clinical test; this rule asks for severe ratings instead."""

StopReason = Literal["severe pain", "rising pain"]
TellReason = Literal["stop", "new pain", "worse pain", "tired"]


class SessionRatings(msgspec.Struct, frozen=True):
    """Ratings of one session; None if not asked, or not answered.

    ``pain_pause``: the worst in a pause. ``told_pain``: pain was said in a pause, with a number or without.
    """

    pain_before: int | None = None
    pain_pause: int | None = None
    pain_after: int | None = None
    fatigue_before: int | None = None
    fatigue_after: int | None = None
    told_pain: bool = False

    @property
    def pain(self) -> int | None:
        """The worst pain of the session: at least 1 if it was told in a pause; None if nothing is known."""
        known = [rating for rating in (self.pain_before, self.pain_pause, self.pain_after) if rating is not None]
        return max([*known, *([1] if self.told_pain else [])], default=None)

    @property
    def fatigue(self) -> int | None:
        """The greatest tiredness of the session; None if nothing is known."""
        known = [rating for rating in (self.fatigue_before, self.fatigue_after) if rating is not None]
        return max(known, default=None)

    @property
    def is_reason_to_stop(self) -> bool:
        """True if pain at any moment was a reason to stop: see `stop_now`."""
        pains = (self.pain_before, self.pain_pause, self.pain_after)
        return any(stop_now(self.pain_before, pain) is not None for pain in pains)


def stop_now(before: int | None, now: int | None) -> StopReason | None:
    """Return why a person should stop and tell the therapist now; None if there is no reason.

    Args:
        before: pain before the session; None if it is not known, or ``now`` is that rating.
        now: pain now.
    """
    if now is None:
        return None
    if now >= SEVERE:
        return "severe pain"
    return "rising pain" if before is not None and now - before >= RISE else None


def tell_therapist(sessions: Sequence[SessionRatings]) -> tuple[TellReason, ...]:
    """Return what the therapist should be told after some sessions of a participant, oldest first.

    Sessions in which nothing is known of a symptom are left out for that symptom.

    - Stop: pain was a reason to stop in the last one.
    - New pain: none before the last four sessions, and some in each of them.
    - Worse pain: more in each of the last four than before them.
    - Tired: severe tiredness after each of the last two.

    The pain before is that of the session before those four; without one, the first rating of the four.
    """
    found: list[TellReason] = []
    known = [session for session in sessions if session.pain is not None]
    if known and known[-1].is_reason_to_stop:
        found.append("stop")
    if len(known) >= PAIN_SESSIONS:
        recent = [session.pain or 0 for session in known[-PAIN_SESSIONS:]]
        earlier = known[-PAIN_SESSIONS - 1].pain if len(known) > PAIN_SESSIONS else known[0].pain_before
        if earlier is not None and min(recent) > earlier:
            found.append("worse pain" if earlier else "new pain")
    tired = [session.fatigue_after for session in sessions if session.fatigue_after is not None]
    if len(tired) >= TIRED_SESSIONS and min(tired[-TIRED_SESSIONS:]) >= SEVERE:
        found.append("tired")
    return tuple(found)
