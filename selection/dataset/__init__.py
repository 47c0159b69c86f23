"""Explorations of many random objects, kept as recordings and one table of truth and estimates."""
