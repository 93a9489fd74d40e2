"""Tasks that `sar-tui tasks new` starts from, a folder for each. They are copied, under the new
task's name.
"""
