"""Version of the rules that a session is played by."""

RULES = 6
"""A session keeps the rules it began with, so that it can be replayed and resumed.

1: the session waits for an operator's decision on feedback and level only, encouragement that is
still due when Enter is pressed is dropped, and each proposal has ``operator_time_ms``.
2: with two participants, feedback for the first replaces feedback for the second on the screen if
an operator decides on that one earlier, and so does a filler; a foreperiod goes on in which the
program was suspended; and the keyboard task has ten levels, some of them far apart.
3: encouragement says the same after two failures and before a new highest level, and wordings of
feedback are chosen whatever has just been said.
4: reaches are found about one axis, and measured about it; and praise for a quality needs a fixed
margin only, that of the time to peak, too, and each change of a result is reported.
5: the question about pain between attempts has other words at its ends; a reach is looked for in
the three seconds before its key, whatever was done in them; feedback on performance names a quality
at random where none has changed; keys count as soon as something appears on the screen, also those
that were down before, and Enter begins an attempt whatever was pressed just before it; and each
repeat of a held key counts where presses are counted.
"""
