"""Parts of the first screen: the list of participants, their card, their sessions."""
