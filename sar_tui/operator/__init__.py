"""The operator's panel: a mirror of the participant, the proposals that wait, and everything an operator can do."""
