"""The runs and measurements of one machine, in an index that is searched, exported and learned from."""

from estimation.store.database import Found, Run, Store
from estimation.store.learning import LearnedClass, Observation, learn_classes, reference_content

__all__ = ["Found", "LearnedClass", "Observation", "Run", "Store", "learn_classes", "reference_content"]
