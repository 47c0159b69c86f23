"""Robot descriptions, objects and reference data, and the code that finds them."""
