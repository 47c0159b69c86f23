"""What an arm carries, from its joint torques: at rest, streamed, or in motion.

At rest: `static` states the estimate, `holds` reduces the readings, `graph` builds the factor graph, `em` weighs
its readings, `noise` describes them. In motion: `derivatives`, `motion_rows`, `drives`, `motion`.
"""

from estimation.payload.estimate import PayloadEstimate
from estimation.payload.noise import JointNoise
from estimation.payload.static import estimate_payload

__all__ = ["JointNoise", "PayloadEstimate", "estimate_payload"]
