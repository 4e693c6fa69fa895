"""The ROS 2 nodes: they declare parameters, convert messages, call the numerics, and publish.

What belongs here: everything that knows rclpy or tissue_probe_msgs. What does not: numerics.
"""
