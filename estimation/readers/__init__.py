"""Readers of recorded runs, one file format each."""
