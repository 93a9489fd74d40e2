"""All that is heard, by one path: `path` is what the outputs use, `voice` the child process that speaks and sounds."""
