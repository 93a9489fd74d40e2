"""The values that all rooms speak: messages, trials, frames, steps, themes. They do nothing."""
