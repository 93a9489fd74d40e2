"""Version of the rules that a session is played by."""

RULES = 6
"""A session keeps the rules it began with, so that it can be replayed and resumed.

1: the session waits for an operator's decision on feedback and level only, encouragement that is still due when Enter
is pressed is dropped, and each proposal has ``operator_time_ms``.
2: with two participants, feedback for the first replaces feedback for the second on the screen if an operator decides
on that one earlier, and so does a filler; a foreperiod goes on in which the program was suspended; and the keyboard
task has ten levels, some of them far apart.
3: encouragement says the same after two failures and before a new highest level, and wordings of feedback are chosen
whatever has just been said.
4: reaches are found about one axis, and measured about it; and praise for a quality needs a fixed margin only,
that of the time to peak, too, and each change of a result is reported.
6: the question about pain between attempts has the words of the one before and after a session at its ends; a reach
is looked for since the end of the reach before, and from the rest just before its key, instead of in the three seconds
before it; and feedback on performance names a quality only if it has changed beyond the person's own noise, instead of
one at random. Between trials, keys that were down when something else appeared on the screen do nothing, nor do those
within 600 ms of its appearance; and an attempt begins after 700 ms without keys. In trials, a key that comes about 20
times a second is held, from its first repeat on.
"""
