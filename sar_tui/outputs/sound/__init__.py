"""Speech and tones on one path: outputs use `mixer`; `voice` is the child process that speaks and plays."""
