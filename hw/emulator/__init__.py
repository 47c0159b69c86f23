"""An arm's server on this machine: the Kortex protocol in front of a robot that exists only in software."""
