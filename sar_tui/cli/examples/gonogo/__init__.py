"""Go/No-Go: some prompts must not be answered."""
