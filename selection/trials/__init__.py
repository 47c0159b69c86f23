"""Experiments: many explorations of many objects, counted, beside the figures that the thesis printed."""
