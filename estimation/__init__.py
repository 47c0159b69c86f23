"""Quantities with calibrated uncertainty from readings, the belief, and what is kept on disk."""
