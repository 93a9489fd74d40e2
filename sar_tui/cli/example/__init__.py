"""The task that `sar-tui tasks new` starts from: finger tapping. It is copied, under the new task's name."""
