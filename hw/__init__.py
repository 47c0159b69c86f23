"""The Kortex arm as a robot."""
