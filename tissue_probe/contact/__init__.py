"""A contact that was identified, put to use: a robot's admittance, and a contact in MuJoCo.

Contents: the contact with its errors and its file, the loop of an admittance and its margins, the
parameters of ros2_controllers' admittance controller, a pair of geoms for MuJoCo.
"""
