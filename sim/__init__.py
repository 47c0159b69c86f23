"""The MuJoCo world as a robot."""
