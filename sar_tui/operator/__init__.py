"""The operator's panel: a state of the participant, the proposals that wait, and everything an operator can do."""
