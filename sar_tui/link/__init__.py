"""The same topics between processes and machines: who may listen, who may act, and how they reach the session."""
