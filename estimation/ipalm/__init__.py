"""The IPALM project's formats: measurement lists, documents of its object database, and a client of its server."""

from estimation.ipalm.documents import Document, Entry, ObjectInstance, Pose, Value, from_json, to_json
from estimation.ipalm.lists import MeasuredObject, MeasurementList, from_list, to_list

__all__ = [
    "Document",
    "Entry",
    "MeasuredObject",
    "MeasurementList",
    "ObjectInstance",
    "Pose",
    "Value",
    "from_json",
    "from_list",
    "to_json",
    "to_list",
]
