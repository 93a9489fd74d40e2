"""The reaches that were found in a recording, corrected by hand."""
