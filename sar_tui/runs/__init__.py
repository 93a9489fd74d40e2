"""Running a session: its plan, its sensors, live and simulated."""
