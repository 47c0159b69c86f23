"""A simulated robot that has closed on an object, for the tests of the simulator."""

import math

import numpy as np

from dynamics.kinematics import solve_pose, straight_joints, straight_line, tool_down
from dynamics.trajectory import time_path
from sim.robot import MujocoRobot
from sim.sensors import SensorModel

SLOW = 0.02  # m/s


class Grasp:
    """A robot that has closed on its object, around which it stands.

    Args:
        truth: the object; the pads close on its width.
        effort: motor current at which it stops closing [A].
    """

    def __init__(self, truth, effort, noise=None, seed=0):
        self.robot = MujocoRobot(truth, noise or SensorModel.none(), seed)
        self.samples = []
        self.robot.listen(self.samples.append)
        gripper, declared = self.robot.gripper, truth.declared
        width, height = truth.size[1], truth.size[2]
        depth = gripper.pad_depth(width) - gripper.tool_depth
        self.pose = tool_down([*declared.position, max(height / 2, 0.024) + depth], declared.yaw)
        above = self.pose.copy()
        above[2, 3] += height
        q = solve_pose(self.robot.arm, above, self.robot.read().q)
        self.robot.follow(time_path(self.robot.arm, straight_joints(self.robot.read().q, q), 1.0))
        self.to(self.pose)
        self.robot.grip(width + 0.004, 0.1, math.inf)
        self.samples.clear()
        self.result = self.robot.grip(0.8 * width, SLOW, effort)
        self.closing = list(self.samples)

    def to(self, pose):
        """Move the tool straight to a pose."""
        commanded = self.robot.read().q
        path = straight_line(self.robot.arm, commanded, pose)
        self.robot.follow(time_path(self.robot.arm, path, 1.0))

    def lift(self, height):
        pose = self.pose.copy()
        pose[2, 3] += height
        self.to(pose)
        self.robot.hold(0.5)

    def weight(self):
        """Return the mass that the arm carries, by the torques of all joints over gravity's [kg]."""
        self.samples.clear()
        self.robot.hold(0.2)
        q = np.mean([s.q for s in self.samples], axis=0)
        load = np.mean([s.tau for s in self.samples], axis=0) - self.robot.arm.gravity(q)
        return np.linalg.lstsq(self.robot.arm.payload_regressor(q), load, rcond=None)[0][0]

    def at_rest(self):
        """Return opening and force after a while of holding still [m, N]: no damping, no acceleration."""
        self.robot.hold(0.5)
        return self.robot._opening(), self.robot._current() * self.robot.gripper.force_per_ampere

    def squeeze(self, travel, effort):
        """Close further; return opening and force of the steady part [m, N]."""
        self.samples.clear()
        self.robot.grip(self.robot.read().opening - travel, SLOW, effort)
        steady = self.samples[3:-2]  # between speeding up and slowing down
        force = np.array([s.effort for s in steady]) * self.robot.gripper.force_per_ampere
        return np.array([s.opening for s in steady]), force
