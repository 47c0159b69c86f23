"""Which action to take next, and the exploration that takes it."""
