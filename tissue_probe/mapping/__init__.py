"""From estimates at single sites to a stiffness map and the stiff regions in it.

What belongs here: the grid of sites, the fusion of estimates at each site, the surface through
the sites, the regions that stand out. What does not: pictures of them (``figures``), ROS
(``nodes``), and how the estimates were made (``estimation``).
"""
