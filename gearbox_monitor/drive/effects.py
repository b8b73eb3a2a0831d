"""
Effects beyond equation (1), switched on by the key ``effects`` of a model file.

Each id names its place and the parameters that a model file gives for it. What stands here is the
load on the arm: equation (1) has none, every real joint has one.
"""
ARM_LOADS = {
    'arm_viscous': ('Cav',),   # tau_arm += Cav x4            N m s/rad
    'arm_coulomb': ('Cac',),   # tau_arm += Cac s(x4)         N m
    'gravity': ('G',),         # tau_arm += G sin(x2)         N m
    'load_torque': ('TL',),    # tau_arm += TL                N m
}
