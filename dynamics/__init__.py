"""Physics from signals to quantities: the arm, the payload, the gripper, stress and strain."""
