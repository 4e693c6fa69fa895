"""The ROS 2 nodes: they declare parameters, convert messages, call the numerics, and publish.

Contents: everything that knows rclpy or tissue_probe_msgs.
"""
