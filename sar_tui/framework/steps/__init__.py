"""Steps between attempts: questions, screens to read, rests and calibrations."""
